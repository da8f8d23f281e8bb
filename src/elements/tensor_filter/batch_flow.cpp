// BatchFlow: collects frames into batches, together with frames of other filters of the same model.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <functional>
#include <mutex>
#include <vector>

#include "core/infer/batch/batch_group.hpp"
#include "core/isolate/isolation.hpp"
#include "elements/tensor_filter/admission.hpp"
#include "elements/tensor_filter/frame_flow.hpp"
#include "elements/tensor_filter/model_report.hpp"
#include "elements/tensor_filter/output_frame.hpp"
#include "gstcpp/buffer/request_expiry.hpp"

namespace weir {
namespace {

class BatchFlow final : public FrameFlow {
 public:
  // One batch may be collected while another one runs.
  BatchFlow(const Owner& owner, const FilterSettings& settings)
      : FrameFlow(owner, settings, size_t{2} * settings.batch_size, true),
        timeout_(int64_t(settings.batch_timeout)) {}
  ~BatchFlow() override { leave(); }

  Status begin(std::shared_ptr<const OpenModel> model, SharedFilterPlan plan) override {
    leave();
    const auto group = plan->batch;
    pairs_ = std::make_shared<Pairs>(std::move(model), std::move(plan), &output_);
    auto joined = infer::BatchGroup::join(group, timeout_);
    std::lock_guard lock(mutex_);
    stream_ = std::move(joined);
    batch_size_ = group->shapes().batch_size;
    last_run_ = 0;
    return ok();
  }

  GstFlowReturn push(gst::Ref<GstBuffer> buffer, GstClockTime deadline) override {
    if (!pairs_) return reject_before_caps();
    if (output_.is_past(deadline)) {
      output_.ledger()->dropped(DropReason::Qos);
      return GST_FLOW_OK;
    }
    if (const auto flow = output_.rejection(); flow != GST_FLOW_OK) return output_.reject(flow);
    Share share;
    using FrameAdmission = infer::HeldBytes::FrameAdmission;
    const uint64_t bytes = gst_buffer_get_size(buffer.get());
    auto admission = infer::HeldBytes::try_frame(output_.held(), bytes, &share);
    if (admission == FrameAdmission::Full) {
      pause();  // no more frames can arrive, so the batch runs incomplete
      admission = infer::HeldBytes::take_frame(output_.held(), bytes, &share);
    }
    if (admission != FrameAdmission::Taken) return output_.reject(admission);
    auto ticket = output_.try_submit();
    while (!ticket && output_.drops_old() && !output_.flushing() && drop_oldest())
      ticket = output_.try_submit();
    if (!ticket && !output_.waits() && !output_.flushing())
      return output_.reject(FrameAdmission::Full);
    if (!ticket) {
      stream()->pause_if_empty();  // downstream blocks: no frame can be added now
      ticket = output_.submit();
    }
    if (!ticket) return output_.reject(GST_FLOW_FLUSHING);
    add(std::move(buffer), deadline, *ticket, std::move(share));
    const auto flow = output_.report_flow();
    const auto failed = output_.failure();
    return failed != GST_FLOW_OK ? failed : flow;
  }

  void drain() override {
    pause();
    FrameFlow::drain();
  }

  void flush() override {
    FrameFlow::flush();
    drop_waiting();
  }

  // Waits for the running batch if it contains frames of this filter.
  void close() override {
    FrameFlow::close();
    leave();
    pairs_.reset();
  }

  void add_stats(GstStructure* stats) const override {
    FrameFlow::add_stats(stats);
    std::lock_guard lock(mutex_);
    if (batch_size_ == 0) return;
    const double mean = runs_ ? static_cast<double>(frames_) / static_cast<double>(runs_) : 0.0;
    gst_structure_set(stats, "batches", G_TYPE_UINT64, runs_, "mean-batch", G_TYPE_DOUBLE, mean,
                      "batch-fill", G_TYPE_DOUBLE, mean / static_cast<double>(batch_size_),
                      nullptr);
  }

 private:
  using Share = infer::HeldBytes::Share;
  using Stream = infer::BatchCollector::Stream;
  struct Pair {
    Pair(const OpenModel* model, const SharedFilterPlan& plan, FilterOutput* output)
        : in(model, plan, 0, output->ledger()), out(output->ledger(), output->pool_allocated()) {}
    InputFrame in;
    OutputFrame out;
  };

  // Reused frames: several are in progress at the same time.
  class Pairs {
   public:
    Pairs(std::shared_ptr<const OpenModel> model, SharedFilterPlan plan, FilterOutput* output)
        : model_(std::move(model)), plan_(std::move(plan)), output_(output) {}

    Result<std::unique_ptr<Pair>> take() {
      {
        std::lock_guard lock(mutex_);
        if (!free_.empty()) {
          auto last = std::move(free_.back());
          free_.pop_back();
          return last;
        }
      }
      auto made = std::make_unique<Pair>(model_.get(), plan_, output_);
      if (auto status = made->out.prepare(plan_); !status) return status.error();
      return made;
    }
    void give_back(std::unique_ptr<Pair> pair) {
      pair->out.clear();
      pair->in.clear();
      std::lock_guard lock(mutex_);
      free_.push_back(std::move(pair));
    }

   private:
    const std::shared_ptr<const OpenModel> model_;
    const SharedFilterPlan plan_;
    FilterOutput* const output_;
    std::mutex mutex_;  // guards free_
    std::vector<std::unique_ptr<Pair>> free_;
  };

  class Frame final : public infer::BatchJob {
   public:
    Frame(BatchFlow* flow, std::unique_ptr<Pair> pair, gst::Ref<GstBuffer> buffer,
          GstClockTime deadline, const Ticket& ticket, Share share)
        : flow_(flow),
          share_(std::move(share)),
          pairs_(flow->pairs_),
          pair_(std::move(pair)),
          buffer_(std::move(buffer)),
          deadline_(deadline),
          ticket_(ticket) {}
    ~Frame() override { pairs_->give_back(std::move(pair_)); }

    Status read() { return pair_->in.read(buffer_.get(), nullptr); }
    std::span<const weir_tensor> inputs() const override { return pair_->in.tensors(); }
    void done(const infer::BatchRun& run, std::span<const weir_tensor> outputs,
              const std::shared_ptr<void>& owner, uint64_t copied) override {
      flow_->output_.ledger()->copied(copied);
      flow_->count(run);
      auto made = pair_->out.collect(pair_->in, outputs, owner);
      if (made) set_answered_by(made->get(), flow_->output_.element(), run.end.answered_by);
      flow_->output_.finish(ticket_, std::move(made));
    }
    int64_t expires() const override {
      return monotonic_deadline(flow_->output_.element(), deadline_);
    }
    bool end_if_useless() override {
      if (!flow_->output_.is_past(deadline_) && !gst::end_if_expired(buffer_.get())) return false;
      flow_->output_.drop_late(ticket_);
      return true;
    }
    void failed(const Error& error) override { flow_->output_.finish(ticket_, error); }
    void dropped(const infer::BatchRun& run) override {
      flow_->count(run);
      flow_->output_.end(ticket_, {}, to_drop_reason(run.end.reason));
    }
    void drop() { flow_->output_.end(ticket_, {}); }

   private:
    BatchFlow* flow_;  // outlives the stream, which outlives this job
    Share share_;
    std::shared_ptr<Pairs> pairs_;
    std::unique_ptr<Pair> pair_;
    gst::Ref<GstBuffer> buffer_;
    GstClockTime deadline_;
    Ticket ticket_;
  };

  // Adds the frame to the stream; a frame that cannot be read ends immediately.
  void add(gst::Ref<GstBuffer> buffer, GstClockTime deadline, const Ticket& ticket, Share share) {
    auto pair = pairs_->take();
    if (!pair) return output_.finish(ticket, pair.error());
    auto frame = std::make_unique<Frame>(this, *std::move(pair), std::move(buffer), deadline,
                                         ticket, std::move(share));
    if (auto status = frame->read(); !status) return frame->failed(status.error());
    stream()->add(std::move(frame));
  }

  std::shared_ptr<Stream> stream() const {
    std::lock_guard lock(mutex_);
    return stream_;
  }
  void pause() override {
    if (const auto joined = stream()) joined->pause();
  }
  // Drops the frames that are not in a running batch.
  void drop_waiting() {
    const auto joined = stream();
    if (!joined) return;
    for (const auto& job : joined->flush()) static_cast<Frame&>(*job).drop();
  }
  bool drop_oldest() {
    const auto job = stream()->take_oldest();
    if (job) static_cast<Frame&>(*job).drop();
    return job != nullptr;
  }
  void leave() {
    drop_waiting();
    std::shared_ptr<Stream> left;  // destroyed without the lock because that may wait for a batch
    std::lock_guard lock(mutex_);
    left.swap(stream_);
  }
  void count(const infer::BatchRun& run) {
    std::lock_guard lock(mutex_);
    if (run.number == last_run_) return;
    last_run_ = run.number;
    ++runs_;
    frames_ += run.frames;
    if (run.end.reason != isolate::kFrameLost) output_.statistics()->record(run.invoke);
  }
  Delay delay() const override {
    const auto wait = static_cast<GstClockTime>(timeout_.count());
    return {wait, wait};
  }

  const std::chrono::nanoseconds timeout_;
  std::shared_ptr<Pairs> pairs_;  // used by the streaming thread; null before caps

  mutable std::mutex mutex_;        // guards the rest
  std::shared_ptr<Stream> stream_;  // replaced only by the streaming thread
  size_t batch_size_ = 0;
  // The last batch with frames of this filter; the number of such batches and of their frames.
  uint64_t last_run_ = 0, runs_ = 0, frames_ = 0;
};

}  // namespace

std::unique_ptr<FrameFlow> make_batch_flow(const FrameFlow::Owner& owner,
                                           const FilterSettings& settings) {
  return std::make_unique<BatchFlow>(owner, settings);
}

}  // namespace weir
