// One AsyncFrame for each frame in work.
#include "elements/tensor_filter/async_frames.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <optional>
#include <string>

#include "elements/tensor_filter/frame_flow.hpp"

namespace weir {
namespace {

// Lives until the engine has ended the request, or its session is freed.
class AsyncFrame final : public infer::RequestReceiver {
 public:
  // `model` outlives the frame: its session holds it.
  AsyncFrame(FrameFlow* flow, const OutputQueue::Ticket& ticket, gst::Ref<GstBuffer> buffer,
             AsyncFrames::Share share, const OpenedModel& model, const FilterPlan& plan)
      : flow_(flow),
        ticket_(ticket),
        share_(std::move(share)),
        buffer_(std::move(buffer)),
        invoker_(flow->make_invoker(
            std::shared_ptr<const OpenedModel>(std::shared_ptr<void>(), &model), plan)) {}
  ~AsyncFrame() override { invoker_.clear(); }
  AsyncFrame(const AsyncFrame&) = delete;
  AsyncFrame& operator=(const AsyncFrame&) = delete;

  Status open(const infer::ModelUse::Frame& frame, GstClockTime deadline) {
    if (auto status = invoker_.prepare(); !status) return status;
    return invoker_.open(frame, buffer_.get(), deadline);
  }
  const FrameInvoker& invoker() const noexcept { return invoker_; }

  void output(weir_frame& frame) noexcept override {
    flow_->heard();
    if (failure_) return;
    try {
      auto made = invoker_.collect(buffer_.get(), frame);
      if (!made) {
        failure_ = made.error();
        return;
      }
      if (auto status = flow_->add(ticket_, *std::move(made)); !status) failure_ = status.error();
      flow_->heard();  // it may have waited there
    } catch (const std::exception&) {
      failure_ = Error{Code::OUT_OF_MEMORY, "no memory for an output", "", "", "", ""};
    }
  }
  void end(Status status) noexcept override {
    flow_->heard();
    if (status && failure_) status = *failure_;
    flow_->end(ticket_, status, std::chrono::steady_clock::now() - begin_);
  }

 private:
  FrameFlow* flow_;
  const OutputQueue::Ticket ticket_;
  const AsyncFrames::Share share_;
  const gst::Ref<GstBuffer> buffer_;
  FrameInvoker invoker_;
  std::optional<Error> failure_;  // of the first output that could not be pushed
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace

Status AsyncFrames::begin(std::shared_ptr<const OpenedModel> model, FilterPlan plan) {
  model_ = std::move(model);
  plan_ = std::move(plan);
  const auto followed = follow_model(true);
  return followed ? ok() : Status(followed.error());
}

Result<AsyncFrames::Answer> AsyncFrames::follow_model(bool waits) {
  auto now = model_->begin();
  if (!now) return now.error();
  const auto before = frame();
  if (before && before->sessions_number() == now->sessions_number()) return Answer::Taken;
  if (before && !waits && before->session().requests().in_flight() > 0) return Answer::Full;
  if (before && !before->session().requests().wait_until_idle()) return Answer::Refused;
  std::lock_guard lock(mutex_);
  frame_ = std::make_shared<const Frame>(*std::move(now));
  return Answer::Taken;
}

size_t AsyncFrames::depth() const {
  return std::max<size_t>(frame()->model().info().max_in_flight, 1);
}

void AsyncFrames::limit_silence(std::chrono::milliseconds limit) {
  if (limit.count() <= 0) return;
  silence_ = std::make_unique<IdleWatch>(TimerQueue::instance(), limit,
                                         [this, limit] { return end_of_patience(limit); });
}

// Cancelling is left to the flush or the stop: an engine that hangs may hang in that too.
bool AsyncFrames::end_of_patience(std::chrono::milliseconds limit) {
  const auto held = frame();
  const auto bytes = flow_->held();
  if (bytes.result_waits) return false;  // the elements behind keep the engine waiting
  if (!held || (!held->session().requests().owes() && !bytes.frame_waits)) return true;
  const auto in_flight = held->session().requests().in_flight();
  const Error error{
      Code::WORKER_TIMEOUT,
      "the engine has said nothing of its frames in time",
      "async-timeout=" + std::to_string(limit.count()) + " ms, frames in work: " +
          std::to_string(in_flight) + (bytes.frame_waits ? ", and one waits for max-bytes" : ""),
      "an output or the end of a frame",
      "",
      "tensor_filter invoke-async=true async-timeout=" + std::to_string(10 * limit.count())};
  flow_->fail_all(error);
  held->session().requests().fail(error);
  return true;
}

Result<AsyncFrames::Answer> AsyncFrames::make_room(bool waits,
                                                   const std::shared_ptr<infer::HeldBytes>& held,
                                                   uint64_t bytes, Share* share) {
  const auto followed = follow_model(waits);
  if (!followed || *followed != Answer::Taken) return followed;
  auto& requests = frame()->session().requests();
  if (!waits && requests.in_flight() >= depth()) return Answer::Full;
  if (!requests.wait_for_room()) return Answer::Refused;
  return infer::HeldBytes::take_frame(held, bytes, share);
}

Result<bool> AsyncFrames::submit(gst::Ref<GstBuffer> buffer, GstClockTime deadline,
                                 const OutputQueue::Ticket& ticket, Share share) {
  const auto held = this->frame();
  auto frame = std::make_shared<AsyncFrame>(flow_, ticket, std::move(buffer), std::move(share),
                                            *model_, plan_);
  if (auto status = frame->open(*held, deadline); !status) return status.error();
  heard();
  return infer::submit(held->session(), frame->invoker().in_frame(), frame);
}

size_t AsyncFrames::flush() {
  const auto held = frame();
  return held ? infer::abandon(held->session()) : 0;
}

void AsyncFrames::resume() {
  const auto held = frame();
  if (!held) return;
  held->session().requests().wait_until_quiet();  // who ended a frame has counted it
  held->session().requests().resume();
}

void AsyncFrames::close() {
  auto held = frame();
  if (held) held->session().requests().wait_until_quiet();
  silence_.reset();  // nobody is heard any more
  {
    std::lock_guard lock(mutex_);
    frame_.reset();
  }
  held.reset();  // before its model
  model_.reset();
}

std::shared_ptr<const AsyncFrames::Frame> AsyncFrames::frame() const {
  std::lock_guard lock(mutex_);
  return frame_;
}

}  // namespace weir
