// FrameFlow: passes the frames of one tensor_filter through its model. There is one file for each
// mode, which is chosen when the model is opened: inline_flow, workers_flow, batch_flow,
// async_flow.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "elements/tensor_filter/filter_output.hpp"
#include "elements/tensor_filter/open_model.hpp"

namespace weir {

class FrameFlow {
 public:
  using Owner = FilterOutput::Owner;
  using SharedFilterPlan = std::shared_ptr<const FilterPlan>;
  // Makes the flow of a stream that starts; each stream has its own.
  static std::unique_ptr<FrameFlow> make(const Owner& owner, const FilterSettings& settings);
  virtual ~FrameFlow() = default;
  FrameFlow(const FrameFlow&) = delete;
  FrameFlow& operator=(const FrameFlow&) = delete;

  // Streaming thread: the frames that follow are processed by `model` with `plan`.
  virtual Status begin(std::shared_ptr<const OpenModel> model, SharedFilterPlan plan) = 0;
  // Streaming thread: processes a frame that the ledger counts as received. If another thread
  // processes it, the returned flow is that of earlier frames. `deadline`: the running time after
  // which an invoke is useless, or none.
  virtual GstFlowReturn push(gst::Ref<GstBuffer> buffer, GstClockTime deadline) = 0;
  // Sends a serialized event after the frames before it. Returns the result of the source pad, or
  // true if it is pushed later.
  bool send(gst::Ref<GstEvent> event);
  // Streaming thread: waits until no frame is in progress.
  virtual void drain() { output_.wait_until_empty(); }

  // Any thread: rejects frames until resume() and drops those in progress.
  virtual void flush() { output_.flush(); }
  virtual void resume() { output_.resume(); }
  // Call before the pads are deactivated: flushes, and ends all pushes from the threads of the
  // flow.
  void stop();
  // Call while no pad is active: waits for the threads of the flow. Afterwards it holds nothing.
  virtual void close() { output_.close(); }

  // Any thread, at the start and when properties change.
  void configure(const FilterSettings& settings) noexcept { output_.configure(settings); }
  // What the filter adds to the pipeline latency: `min` is the wait for a worker or a batch,
  // `max` how long frames can be kept without blocking the source. Both include the invoke if it
  // is reported.
  struct Delay {
    GstClockTime min = 0, max = 0;
  };
  Delay report_latency();
  virtual void add_stats(GstStructure* stats) const { output_.add_stats(stats, pool_state()); }

 protected:
  using Ticket = FilterOutput::Ticket;
  FrameFlow(const Owner& owner, const FilterSettings& settings, size_t depth, bool with_task)
      : output_(owner, settings, depth, with_task) {}
  // Rejects a buffer that arrived before begin().
  GstFlowReturn reject_before_caps();
  // Called when no frame will follow soon: at a GAP event, at EOS and for a drain query.
  virtual void pause() {}
  virtual Delay delay() const { return {}; }
  // Overridden by flows with workers; here the streaming thread is the only worker.
  virtual infer::PoolState pool_state() const;

  FilterOutput output_;
};

std::unique_ptr<FrameFlow> make_inline_flow(const FrameFlow::Owner&, const FilterSettings&);
std::unique_ptr<FrameFlow> make_workers_flow(const FrameFlow::Owner&, const FilterSettings&);
std::unique_ptr<FrameFlow> make_batch_flow(const FrameFlow::Owner&, const FilterSettings&);
std::unique_ptr<FrameFlow> make_async_flow(const FrameFlow::Owner&, const FilterSettings&);

}  // namespace weir
