// WorkersFlow: dispatches frames to workers, each with its own thread and session.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <mutex>
#include <vector>

#include "elements/tensor_filter/frame_flow.hpp"
#include "elements/tensor_filter/frame_invoker.hpp"
#include "gstcpp/buffer/request_expiry.hpp"
#include "gstcpp/element/element.hpp"

namespace weir {
namespace {

class WorkersFlow final : public FrameFlow {
 public:
  // In addition to the frames in the pool, results may wait for an older frame.
  WorkersFlow(const Owner& owner, const FilterSettings& settings, const infer::PoolLimits& limits)
      : FrameFlow(owner, settings, 2 * limits.workers + limits.ahead(), false),
        limits_(limits),
        pool_(std::make_shared<Pool>(
            limits, [this](size_t worker, Job job) { run(worker, std::move(job)); })) {}

  Status begin(std::shared_ptr<const OpenModel> model, SharedFilterPlan plan) override {
    const auto& rate = plan->input.rate;
    frame_duration_ = rate.numerator > 0
                          ? gst_util_uint64_scale(GST_SECOND, rate.denominator, rate.numerator)
                          : 0;
    auto made = std::make_shared<Invokers>();
    for (size_t i = 0; i < limits_.workers; ++i) {
      made->push_back(std::make_unique<FrameInvoker>(model, i, plan, &output_));
      if (i > 0)
        made->back()->prepare_beside(*made->front());
      else if (auto status = made->back()->prepare(); !status)
        return status;
    }
    invokers_ = std::move(made);
    return ok();
  }

  GstFlowReturn push(gst::Ref<GstBuffer> buffer, GstClockTime deadline) override {
    if (!invokers_) return reject_before_caps();
    if (const auto flow = output_.rejection(); flow != GST_FLOW_OK) return output_.reject(flow);
    const uint64_t bytes = gst_buffer_get_size(buffer.get());
    auto use = invokers_->front()->model().lease().begin();
    if (!use) return output_.fail(use.error());
    const auto room = pool_->make_room(bytes);
    drop(room.dropped);
    std::optional<Ticket> ticket;
    if (room.granted) ticket = output_.waits() ? output_.submit() : output_.try_submit();
    if (!ticket && (output_.flushing() || output_.waits()))
      return output_.reject(GST_FLOW_FLUSHING);
    if (ticket)
      pool_->put({*ticket, std::move(buffer), deadline, invokers_, *std::move(use)}, bytes);
    else
      output_.ledger()->dropped(DropReason::Policy);
    return output_.report_flow();
  }

  void drain() override {
    FrameFlow::drain();
    // Flushed frames keep their worker busy until they end.
    if (const auto pool = this->pool()) pool->wait_until_idle();
  }

  void flush() override {
    output_.reject_frames();
    std::vector<Job> waiting;
    {
      std::lock_guard lock(mutex_);
      if (pool_) waiting = pool_->flush();
    }
    FrameFlow::flush();
    drop(waiting);
  }

  void resume() override {
    FrameFlow::resume();
    std::lock_guard lock(mutex_);
    if (pool_) pool_->resume();
  }

  void close() override {
    FrameFlow::close();
    if (pool_) drop(pool_->flush());
    std::shared_ptr<Pool> ended;
    {
      std::lock_guard lock(mutex_);
      ended.swap(pool_);
    }
    ended.reset();
    invokers_.reset();
  }

 private:
  using Invokers = std::vector<std::unique_ptr<FrameInvoker>>;  // one per worker
  struct Job {
    Ticket ticket;
    gst::Ref<GstBuffer> buffer;
    GstClockTime deadline;
    std::shared_ptr<const Invokers> invokers;
    infer::ModelLease::Frame use;
  };
  using Pool = infer::WorkerPool<Job>;

  std::shared_ptr<Pool> pool() const {
    std::lock_guard lock(mutex_);
    return pool_;
  }

  void run(size_t worker, Job job) noexcept {
    gst::guarded<void>(output_.element(), [&] {
      if (output_.is_past(job.deadline) || gst::end_if_expired(job.buffer.get())) {
        job.buffer = {};
        output_.drop_late(job.ticket);
        return;
      }
      auto& invoker = *(*job.invokers)[worker];
      auto made = invoker.run(std::move(job.use), job.buffer.get(), job.deadline);
      output_.check_latency();
      job.buffer = {};
      output_.finish(job.ticket, std::move(made), invoker.drop_reason());
    });
  }
  void drop(const std::vector<Job>& jobs) {
    for (const Job& job : jobs) output_.end(job.ticket, {});
  }

  Delay delay() const override {
    std::lock_guard lock(mutex_);
    if (!pool_) return {};
    const auto us = static_cast<GstClockTime>(std::max(0, output_.statistics()->latency_us()));
    const GstClockTime wait = us * 1000 * limits_.ahead() / limits_.workers;
    return {wait, std::max(wait, (limits_.workers + limits_.ahead()) * frame_duration_)};
  }
  infer::PoolState pool_state() const override {
    std::lock_guard lock(mutex_);
    return pool_ ? pool_->state() : FrameFlow::pool_state();
  }

  const infer::PoolLimits limits_;
  std::shared_ptr<const Invokers> invokers_;     // used by the streaming thread; null before caps
  std::atomic<GstClockTime> frame_duration_{0};  // from the caps; 0 = no rate
  mutable std::mutex mutex_;                     // guards pool_ while it closes
  std::shared_ptr<Pool> pool_;  // null after close(); last member: its threads use the others
};

}  // namespace

std::unique_ptr<FrameFlow> make_workers_flow(const FrameFlow::Owner& owner,
                                             const FilterSettings& settings) {
  return std::make_unique<WorkersFlow>(owner, settings, pool_limits(settings));
}

}  // namespace weir
