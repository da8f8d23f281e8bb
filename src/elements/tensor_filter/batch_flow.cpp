// From buffers to jobs of a batch and back.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/batch_flow.hpp"

namespace weir {

// Readers and writers of frames, used again: several frames are on their way at a time.
class BatchFlow::Invokers {
 public:
  using Make = std::function<std::unique_ptr<FrameInvoker>()>;
  explicit Invokers(Make make) : make_(std::move(make)) {}

  Result<std::unique_ptr<FrameInvoker>> take() {
    {
      std::lock_guard lock(mutex_);
      if (!free_.empty()) {
        auto last = std::move(free_.back());
        free_.pop_back();
        return last;
      }
    }
    auto made = make_();
    if (auto status = made->prepare(); !status) return status.error();
    return made;
  }
  void give_back(std::unique_ptr<FrameInvoker> invoker) {
    invoker->clear();
    std::lock_guard lock(mutex_);
    free_.push_back(std::move(invoker));
  }

 private:
  const Make make_;
  std::mutex mutex_;  // guards free_
  std::vector<std::unique_ptr<FrameInvoker>> free_;
};

class BatchFlow::Frame final : public infer::BatchJob {
 public:
  Frame(BatchFlow* flow, std::unique_ptr<FrameInvoker> invoker, gst::Ref<GstBuffer> buffer,
        const Ticket& ticket, infer::HeldBytes::Share share)
      : flow_(flow),
        share_(std::move(share)),
        invokers_(flow->invokers_),
        invoker_(std::move(invoker)),
        buffer_(std::move(buffer)),
        ticket_(ticket) {}
  ~Frame() override { invokers_->give_back(std::move(invoker_)); }

  Status read() { return invoker_->begin(buffer_.get()); }
  std::span<const weir_tensor> inputs() const override { return invoker_->inputs(); }
  void done(const infer::BatchRun& run, std::span<const weir_tensor> outputs,
            const std::shared_ptr<void>& owner, uint64_t copied) override {
    flow_->ledger_->copied(copied);
    flow_->ran(run);
    flow_->end_(ticket_, invoker_->end(buffer_.get(), outputs, owner));
  }
  void failed(const Error& error) override { flow_->end_(ticket_, error); }
  void dropped(const infer::BatchRun& run) override {
    flow_->ran(run);
    drop();
  }
  void drop() { flow_->end_(ticket_, gst::Ref<GstBuffer>{}); }

 private:
  BatchFlow* flow_;  // outlives the stream, which outlives this
  infer::HeldBytes::Share share_;
  std::shared_ptr<Invokers> invokers_;
  std::unique_ptr<FrameInvoker> invoker_;
  gst::Ref<GstBuffer> buffer_;
  Ticket ticket_;
};

BatchFlow::BatchFlow(Ledger* ledger, infer::InvokeStatistics* statistics,
                     std::atomic<uint64_t>* pool_allocated, End end)
    : ledger_(ledger),
      statistics_(statistics),
      pool_allocated_(pool_allocated),
      end_(std::move(end)) {}

BatchFlow::~BatchFlow() {
  close();
}

void BatchFlow::open() {
  std::lock_guard lock(mutex_);
  last_run_ = runs_ = frames_ = 0;
}

void BatchFlow::close() {
  leave();
  invokers_.reset();
}

std::shared_ptr<BatchFlow::Stream> BatchFlow::stream() const {
  std::lock_guard lock(mutex_);
  return stream_;
}

void BatchFlow::leave() {
  flush();
  std::shared_ptr<Stream> left;  // ends without the lock: it may wait for a batch
  std::lock_guard lock(mutex_);
  left.swap(stream_);
}

void BatchFlow::begin(std::shared_ptr<const OpenedModel> model, FilterPlan plan,
                      std::chrono::nanoseconds timeout) {
  leave();
  const auto group = plan.batch;
  invokers_ = std::make_shared<Invokers>([this, model, plan] {
    return std::make_unique<FrameInvoker>(model, 0, plan, statistics_, ledger_, pool_allocated_);
  });
  auto joined = infer::BatchGroup::join(group, timeout);
  std::lock_guard lock(mutex_);
  stream_ = std::move(joined);
  batch_size_ = group->shapes().batch_size;
  last_run_ = 0;
}

void BatchFlow::add(gst::Ref<GstBuffer> buffer, const Ticket& ticket,
                    infer::HeldBytes::Share share) {
  auto invoker = invokers_->take();
  if (!invoker) return end_(ticket, invoker.error());
  auto frame = std::make_unique<Frame>(this, *std::move(invoker), std::move(buffer), ticket,
                                       std::move(share));
  if (auto status = frame->read(); !status) return frame->failed(status.error());
  stream()->add(std::move(frame));
}

void BatchFlow::pause() {
  if (const auto joined = stream()) joined->pause();
}

void BatchFlow::held_up() {
  if (const auto joined = stream()) joined->pause_if_empty();
}

void BatchFlow::flush() {
  const auto joined = stream();
  if (!joined) return;
  for (const auto& job : joined->flush()) static_cast<Frame&>(*job).drop();
}

bool BatchFlow::drop_oldest() {
  const auto joined = stream();
  const auto job = joined ? joined->take_oldest() : nullptr;
  if (job) static_cast<Frame&>(*job).drop();
  return job != nullptr;
}

void BatchFlow::ran(const infer::BatchRun& run) {
  std::lock_guard lock(mutex_);
  if (run.number == last_run_) return;
  last_run_ = run.number;
  ++runs_;
  frames_ += run.frames;
  statistics_->record(run.invoke);
}

void BatchFlow::add_stats(GstStructure* stats) const {
  std::lock_guard lock(mutex_);
  if (batch_size_ == 0) return;
  const double mean = runs_ ? static_cast<double>(frames_) / static_cast<double>(runs_) : 0.0;
  gst_structure_set(stats, "batches", G_TYPE_UINT64, runs_, "mean-batch", G_TYPE_DOUBLE, mean,
                    "batch-fill", G_TYPE_DOUBLE, mean / static_cast<double>(batch_size_), nullptr);
}

}  // namespace weir
