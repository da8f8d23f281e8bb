// BatchFlow: the frames of one tensor_filter on their way through batches, beside those of others.
#pragma once
#include <gst/gst.h>

#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "core/infer/batch_group.hpp"
#include "core/infer/held_bytes.hpp"
#include "core/infer/invoke_statistics.hpp"
#include "core/ledger/ledger.hpp"
#include "elements/tensor_filter/frame_invoker.hpp"
#include "elements/tensor_filter/output_queue.hpp"

namespace weir {

class BatchFlow {
 public:
  using Ticket = OutputQueue::Ticket;
  using Made = Result<gst::Ref<GstBuffer>>;
  // Ends a frame with its output, null when it was dropped, or its error. Called from any thread,
  // and must not wait: other streams do until it returns.
  using End = std::function<void(const Ticket&, Made)>;

  // All are borrowed, and `end` outlives this.
  BatchFlow(Ledger* ledger, infer::InvokeStatistics* statistics,
            std::atomic<uint64_t>* pool_allocated, End end);
  ~BatchFlow();

  // Counts from the start.
  void open();
  // Nothing is held afterwards. Waits for the batch that runs, when it has frames of this filter.
  void close();
  bool active() const noexcept { return invokers_ != nullptr; }
  // Frames that follow go through the group of the plan; those before have ended or were flushed.
  void begin(std::shared_ptr<const OpenedModel> model, FilterPlan plan,
             std::chrono::nanoseconds timeout);
  // Streaming thread. A frame that cannot be read is ended at once.
  // `share` is let go with it.
  void add(gst::Ref<GstBuffer> buffer, const Ticket& ticket, infer::HeldBytes::Share share);
  // Nobody is to wait for frames of this filter until the next add(): the stream ended.
  void pause();
  // The elements behind hold the stream up, so that no frame can be added now.
  void held_up();
  // Any thread: ends what no batch has begun, as dropped; the oldest of it, false when there is
  // none.
  void flush();
  bool drop_oldest();

  void add_stats(GstStructure* stats) const;

 private:
  class Frame;
  class Invokers;
  using Stream = infer::BatchGatherer::Stream;

  std::shared_ptr<Stream> stream() const;
  void leave();
  void ran(const infer::BatchRun& run);

  Ledger* ledger_;
  infer::InvokeStatistics* statistics_;
  std::atomic<uint64_t>* pool_allocated_;
  const End end_;
  std::shared_ptr<Invokers> invokers_;  // null: frames do not go through batches

  mutable std::mutex mutex_;        // guards the rest
  std::shared_ptr<Stream> stream_;  // replaced by the streaming thread only
  size_t batch_size_ = 0;
  uint64_t last_run_ = 0, runs_ = 0, frames_ = 0;  // batches with frames of this filter; of all
};

}  // namespace weir
