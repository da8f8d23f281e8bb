// FilterOutput: pushes the results of tensor_filter in every mode. Buffers and serialized events
// leave in stream order, although frames may end on any thread. It counts what happens to each
// frame and posts the first of several errors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <variant>

#include "core/filter/latency_report.hpp"
#include "core/infer/model/invoke_statistics.hpp"
#include "core/infer/queue/completion_queue.hpp"
#include "core/infer/queue/held_bytes.hpp"
#include "core/infer/queue/worker_pool.hpp"
#include "core/ledger/ledger.hpp"
#include "elements/tensor_filter/filter_settings.hpp"
#include "gstcpp/element/push_task.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir {

infer::PoolLimits pool_limits(const FilterSettings& settings);
// Counts a frame that the engine dropped; `result`: what its invoke returned (weir_no_result).
DropReason to_drop_reason(int result) noexcept;

// Any thread may call the functions unless noted otherwise.
class FilterOutput {
  struct Part {  // one of the outputs of a frame
    gst::Ref<GstBuffer> buffer;
    uint64_t bytes;
  };
  struct Ended {  // follows the last output of a frame
    int reason;   // 0, or a weir_no_result
  };
  using Entry = std::variant<gst::Ref<GstBuffer>, gst::Ref<GstEvent>, Part, Ended>;
  using Queue = infer::CompletionQueue<Entry>;

 public:
  using Ticket = Queue::Ticket;
  using Made = Result<gst::Ref<GstBuffer>>;
  // Borrowed from the element.
  struct Owner {
    GstElement* element;
    GstPad* source;
    Ledger* ledger;
    infer::InvokeStatistics* statistics;
  };
  // Construct before the pads are activated. `depth`: the maximum number of frames between
  // submission and push. With a task, the source pad's thread pushes, so that threads that end a
  // frame never wait for downstream, and stats include held(). Without one, the thread that ends
  // the oldest frame pushes.
  FilterOutput(const Owner& owner, const FilterSettings& settings, size_t depth, bool with_task);
  // stop(): call before the pads are deactivated; close(): after.
  void stop() { task_.close(); }
  void close() { task_.join(); }

  Ledger* ledger() const noexcept { return owner_.ledger; }
  infer::InvokeStatistics* statistics() const noexcept { return owner_.statistics; }
  GstElement* element() const noexcept { return owner_.element; }
  std::atomic<uint64_t>* pool_allocated() noexcept { return &pool_allocated_; }
  // The bytes of frames in batches and in engines with their own threads, and of outputs between
  // add() and their push. Workers have their own limit.
  const std::shared_ptr<infer::HeldBytes>& held() const noexcept { return held_; }
  bool waits() const noexcept { return when_busy_ == infer::WhenBusy::Block; }
  bool drops_old() const noexcept { return when_busy_ == infer::WhenBusy::DropOld; }
  bool flushing() const noexcept { return flushing_; }
  bool is_past(GstClockTime deadline) const noexcept;

  // Reserves a place for a frame that begins now, and waits for it. nullopt while flushing.
  std::optional<Ticket> submit() { return queue_.submit(); }
  // The same without waiting: nullopt also when there is no place.
  std::optional<Ticket> try_submit() { return queue_.try_submit(); }
  void set_depth(size_t depth) { queue_.set_depth(depth); }

  // Counts a frame without a ticket as dropped. Returns the flow that push() returns.
  GstFlowReturn reject(GstFlowReturn flow);
  GstFlowReturn reject(infer::HeldBytes::FrameAdmission admission);
  GstFlowReturn fail(const Error& error);
  // Why no more frames are accepted: a failure on another thread, or the flow of the source pad.
  GstFlowReturn rejection() const noexcept;
  GstFlowReturn failure() const noexcept { return failed_; }
  // The last flow of the source pad, now reported upstream; OK after a flush. A failure that was
  // never reported upstream is posted at EOS.
  GstFlowReturn report_flow() noexcept {
    flow_is_reported_ = true;
    return flow_;
  }

  // Ends a frame with its output, null when the engine dropped it for `reason`, or with an error,
  // see fail_all(). In place of an output without memory, a GAP event is sent.
  void finish(const Ticket& ticket, Made made, DropReason reason = DropReason::Policy);
  // The same; returns the flow of the source pad.
  GstFlowReturn end(const Ticket& ticket, gst::Ref<GstBuffer> output,
                    DropReason reason = DropReason::Policy);
  // Ends a frame that is too late for an invoke.
  void drop_late(const Ticket& ticket);
  // Ends a frame without output, which the caller counts. False if it was flushed.
  bool skip(const Ticket& ticket);
  // False if the frame was flushed. Post and count everything about a frame before skip(), so that
  // it happens before later entries are pushed.
  bool holds(const Ticket& ticket) const { return queue_.holds(ticket); }

  // For engines that answer asynchronously: adds one output. At the limit of bytes it waits until
  // others were pushed, or is dropped. One without memory becomes a GAP event. An error if the held
  // outputs wait for the end of an older frame.
  Status add(const Ticket& ticket, gst::Ref<GstBuffer> output);
  // Ends the frame, `took` after it began, with what the engine returned. Errors as in finish().
  // The frame counts as consumed, or as dropped when its result is late, refused or lost; outputs
  // that were added before are pushed.
  void end(const Ticket& ticket, const Result<int>& ended, std::chrono::nanoseconds took);
  // Rejects all frames until resume(). Posts the first of several errors.
  void fail_all(const Error& error);

  // Sends a serialized event in its place. Returns the result of the source pad, or true if it is
  // pushed later.
  bool send(gst::Ref<GstEvent> event);
  // Waits until all frames have ended and were pushed or flushed.
  void wait_until_empty() { queue_.wait_until_empty(); }

  // Both reject frames until resume(); flush() also drops those that wait for their push.
  void reject_frames();
  void flush();
  // Waits until no thread pushes anything from before the flush.
  void resume();

  void configure(const FilterSettings& settings) noexcept { reports_ = settings.latency_report; }
  // Call after an invoke: posts a LATENCY message if the latency changed.
  void check_latency() noexcept;
  // The latency of an invoke in nanoseconds, from now on the reported one.
  GstClockTime report_latency() noexcept;
  void add_stats(GstStructure* stats, infer::PoolState pool) const;

 private:
  class Waiting;  // the outputs that HeldBytes may drop or wait for
  void push_finished() { with_task_ ? task_.wake() : drain(); }
  void drain();
  void push(Entry entry) noexcept;
  void push_gap(GstBuffer* frame) noexcept;
  void post_flow() noexcept;

  const Owner owner_;
  const infer::WhenBusy when_busy_;
  const std::shared_ptr<infer::HeldBytes> held_;
  const bool with_task_;
  gst::PushTask task_;
  Queue queue_;
  std::atomic<GstFlowReturn> flow_{GST_FLOW_OK};
  std::atomic<bool> flow_is_reported_{false}, event_taken_{true};
  std::atomic<GstFlowReturn> failed_{GST_FLOW_OK};  // the flow of fail_all(), until resume()
  std::atomic<bool> flushing_{false};
  LatencyReport report_;
  std::atomic<bool> reports_{false};
  std::atomic<uint64_t> pool_allocated_{0};
};

}  // namespace weir
