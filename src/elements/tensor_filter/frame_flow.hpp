// FrameFlow: the way of frames through the model of one tensor_filter, on the thread that brings
// them or on workers of its own. They leave in the order in which they came.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <vector>

#include "core/filter/latency_report.hpp"
#include "core/infer/invoke_statistics.hpp"
#include "core/infer/worker_pool.hpp"
#include "core/ledger/ledger.hpp"
#include "elements/tensor_filter/async_frames.hpp"
#include "elements/tensor_filter/batch_flow.hpp"
#include "elements/tensor_filter/frame_invoker.hpp"
#include "elements/tensor_filter/opened_model.hpp"
#include "elements/tensor_filter/output_queue.hpp"

namespace weir {

class FrameFlow {
 public:
  explicit FrameFlow(Ledger* ledger) : ledger_(ledger), queue_(ledger) {}
  // Both are the element's own; errors of frames are posted on it.
  void set_element(GstElement* element, GstPad* source) noexcept;

  // A new stream of frames may come: counts from the start. Workers begin where there are several,
  // or where `when_busy` is set.
  void open(const FilterSettings& settings);
  // Before the pads are deactivated: flush(), and nothing is pushed on a thread of its own any
  // more.
  void stop();
  // Streaming has ended, no pad is active: waits for the workers; nothing is held then.
  void close();
  // The frames that follow go through `model` as `plan` says, each on the worker's own session.
  Status begin(std::shared_ptr<const OpenedModel> model, const FilterPlan& plan);

  // A frame that is in the ledger as received. On workers the flow is that of earlier frames.
  // `deadline`: the running time from which on it is not worth an invoke, or none.
  GstFlowReturn take(gst::Ref<GstBuffer> buffer, GstClockTime deadline);
  using Ticket = OutputQueue::Ticket;
  using Made = Result<gst::Ref<GstBuffer>>;
  // Ends a frame that was begun, on any thread: its output, null when the engine dropped it, or its
  // error. Of several errors the first is posted, and take() refuses what comes until resume().
  void finish(const Ticket& ticket, Made made);
  // Of an engine that answers asynchronously, on any thread: one output, and the end of a frame,
  // `took` after it was begun. Errors as in finish().
  Status add(const Ticket& ticket, gst::Ref<GstBuffer> output);
  void end(const Ticket& ticket, const Status& status, std::chrono::nanoseconds took);
  infer::HeldBytes::State held() const { return held_->state(); }
  // The engine has said something.
  void heard() { async_.heard(); }
  // What comes from now on is refused, until resume(). Of several errors the first is posted.
  void fail_all(const Error& error);
  FrameInvoker make_invoker(std::shared_ptr<const OpenedModel> model, const FilterPlan& plan) {
    return {std::move(model), 0, plan, &statistics_, ledger_, &pool_allocated_};
  }
  // A serialized event, behind the frames before it. Returns what the source pad answered, TRUE
  // when it is to be pushed later.
  bool send(gst::Ref<GstEvent> event);
  // Waits until no frame is in work; on the thread that brings them.
  void drain();

  // Until resume() nothing is taken, and what has begun is dropped.
  void flush();
  void resume();

  // What workers add to an invoke: a frame's wait for one when all are busy, as measured; and how
  // long frames can be kept without making the source wait. What batches add: a frame's wait for
  // others. Both 0 without either.
  struct Delay {
    GstClockTime least = 0, most = 0;
  };
  Delay delay() const;
  // Any thread: what the user wants, at the start and when it changes.
  void configure(const FilterSettings& settings) noexcept { reports_ = settings.latency_report; }
  bool reports_latency() const noexcept { return reports_; }
  // What the frames' way adds to the latency of the pipeline, ns, as told from now on.
  GstClockTime answer_latency() noexcept;

  const infer::InvokeStatistics& statistics() const noexcept { return statistics_; }
  void add_stats(GstStructure* stats) const;

 private:
  using Invokers = std::vector<std::unique_ptr<FrameInvoker>>;  // one for each worker
  struct Job {
    Ticket ticket;
    gst::Ref<GstBuffer> buffer;
    GstClockTime deadline;
    std::shared_ptr<const Invokers> invokers;
    infer::ModelUse::Frame frame;
  };

  GstFlowReturn take_inline(gst::Ref<GstBuffer> buffer, GstClockTime deadline);
  GstFlowReturn hand_on(gst::Ref<GstBuffer> buffer, GstClockTime deadline);
  void drop_late(const Ticket& ticket);
  GstFlowReturn gather(gst::Ref<GstBuffer> buffer);
  GstFlowReturn refuse(GstFlowReturn flow);
  void drop(const std::vector<Job>& jobs);
  void run(size_t worker, Job job) noexcept;
  GstFlowReturn fail(const Error& error);
  // Why no further frame is wanted, of what other threads have met: failures, the source pad's
  // flow.
  GstFlowReturn refusal() const noexcept;
  GstFlowReturn end(const Ticket& ticket, gst::Ref<GstBuffer> output);
  void check_latency() noexcept;
  GstFlowReturn take_async(gst::Ref<GstBuffer> buffer, GstClockTime deadline);

  // Of a frame that is not taken: it is dropped because all is full, or there was a flush or a
  // failure.
  GstFlowReturn give_up(infer::HeldBytes::Answer answer);

  Ledger* ledger_;                 // borrowed
  GstElement* element_ = nullptr;  // borrowed: the owner
  OutputQueue queue_;
  std::shared_ptr<const Invokers> invokers_;  // streaming thread only
  // Of frames that batches and engines of their own threads have, and of the latter's outputs;
  // workers have a bound of their own. Replaced while no pad is active, by workers_mutex_ too.
  std::shared_ptr<infer::HeldBytes> held_ =
      std::make_shared<infer::HeldBytes>(0, infer::WhenBusy::Block);
  bool counts_held_ = false;   // guarded by workers_mutex_: stats show those bytes
  bool asynchronous_ = false;  // streaming thread only; `async_` has the frames
  AsyncFrames async_{this};
  infer::InvokeStatistics statistics_;
  LatencyReport report_;
  std::atomic<bool> reports_{false};
  std::atomic<uint64_t> pool_allocated_{0};
  std::chrono::nanoseconds batch_timeout_{-1};  // < 0: frames are not gathered
  BatchFlow batch_{ledger_, &statistics_, &pool_allocated_,
                   [this](const Ticket& ticket, Made made) { finish(ticket, std::move(made)); }};
  std::atomic<GstFlowReturn> failed_{GST_FLOW_OK};  // what finish() met, until resume()
  std::atomic<bool> flushing_{false};
  std::atomic<GstClockTime> frame_duration_{0};  // of the caps; 0 = they say no rate
  bool waits_ = true;                            // for room, instead of dropping
  bool drops_old_ = false;                       // what waits, to make room

  mutable std::mutex workers_mutex_;  // guards workers_ against stats while it opens and closes
  std::unique_ptr<infer::WorkerPool<Job>> workers_;  // null: frames stay on their thread
};

}  // namespace weir
