// AsyncFlow: frames for an engine that answers on its own threads, with any number of outputs each.
//
// Outputs are pushed in the order of the frames, those of the oldest frame as they arrive, with the
// timestamps and metadata of their frame. A frame counts as consumed when the engine reports its
// end. A flush cancels the frames in progress and counts them as dropped; their places become free
// when the engine has ended them (core/infer/model/async_request.hpp).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <mutex>
#include <optional>

#include "core/timer/idle_watch.hpp"
#include "elements/tensor_filter/admission.hpp"
#include "elements/tensor_filter/frame_flow.hpp"
#include "elements/tensor_filter/output_frame.hpp"

namespace weir {
namespace {

class AsyncFlow final : public FrameFlow {
 public:
  AsyncFlow(const Owner& owner, const FilterSettings& settings)
      : FrameFlow(owner, settings, 1, true) {
    const std::chrono::milliseconds limit(settings.async_timeout);
    if (limit.count() > 0)
      timeout_watch_ = std::make_unique<IdleWatch>(
          TimerQueue::instance(), limit, [this, limit] { return fail_on_timeout(limit); });
  }

  Status begin(std::shared_ptr<const OpenModel> model, SharedFilterPlan plan) override {
    model_ = std::move(model);
    plan_ = std::move(plan);
    if (const auto followed = follow_model(true); !followed) return followed.error();
    output_.set_depth(depth());
    return ok();
  }

  GstFlowReturn push(gst::Ref<GstBuffer> buffer, GstClockTime deadline) override {
    if (!model_) return reject_before_caps();
    if (const auto flow = output_.rejection(); flow != GST_FLOW_OK) return output_.reject(flow);
    const auto ticket = output_.waits() ? output_.submit() : output_.try_submit();
    if (!ticket)
      return output_.reject(output_.waits() || output_.flushing() ? FrameAdmission::Refused
                                                                  : FrameAdmission::Full);
    Share share;
    const auto room = make_room(gst_buffer_get_size(buffer.get()), &share);
    if (!room || *room != FrameAdmission::Taken) {
      output_.skip(*ticket);
      return room ? output_.reject(*room) : output_.fail(room.error());
    }
    if (output_.is_past(deadline)) {
      output_.drop_late(*ticket);
      return GST_FLOW_OK;
    }
    const auto begun = submit(std::move(buffer), deadline, *ticket, std::move(share));
    if (begun && *begun) return output_.report_flow();
    output_.skip(*ticket);
    return begun ? output_.reject(FrameAdmission::Refused) : output_.fail(begun.error());
  }

  void flush() override {
    FrameFlow::flush();
    const auto held = use();
    if (held) output_.ledger()->dropped(DropReason::Flush, held->session().abandon());
  }

  void resume() override {
    if (const auto held = use()) {
      held->session().requests().wait_until_quiet();  // ended frames are counted in the ledger
      held->session().requests().resume();
    }
    FrameFlow::resume();
  }

  void close() override {
    FrameFlow::close();
    auto held = use();
    if (held) held->session().requests().wait_until_quiet();
    timeout_watch_.reset();  // the engine makes no more calls
    {
      std::lock_guard lock(mutex_);
      use_.reset();
    }
    held.reset();  // must be released before its model
    model_.reset();
  }

 private:
  using FrameAdmission = infer::HeldBytes::FrameAdmission;
  using Share = infer::HeldBytes::Share;
  using Use = infer::ModelLease::Frame;

  // Kept alive until the engine has ended the request, or its session is freed.
  class Frame final : public infer::RequestReceiver {
   public:
    // The model outlives the frame because the session holds it.
    Frame(AsyncFlow* flow, const Ticket& ticket, gst::Ref<GstBuffer> buffer, Share share)
        : flow_(flow),
          ticket_(ticket),
          share_(std::move(share)),
          buffer_(std::move(buffer)),
          in_(flow->model_.get(), flow->plan_, 0, flow->output_.ledger()),
          out_(flow->output_.ledger(), flow->output_.pool_allocated()) {}

    Status read(const Use& use, GstClockTime deadline) {
      if (auto status = in_.read(buffer_.get(), &use, deadline); !status) return status;
      in_.set_expiry(monotonic_deadline(flow_->output_.element(), deadline));
      return out_.prepare(in_.plan());
    }
    const weir_frame& frame() const noexcept { return in_.frame(); }

    void output(weir_frame& frame) noexcept override {
      flow_->touch();
      if (failure_) return;
      try {
        auto made = out_.collect(in_, frame);
        if (!made) {
          failure_ = made.error();
          return;
        }
        if (auto status = flow_->output_.add(ticket_, *std::move(made)); !status)
          failure_ = status.error();
        flow_->touch();  // add() may have waited for downstream
      } catch (const std::exception&) {
        failure_ = Error{.code = Code::OUT_OF_MEMORY, .what = "no memory for an output"};
      }
    }
    void end(const Result<int>& ended) noexcept override {
      flow_->touch();
      const auto took = std::chrono::steady_clock::now() - begin_;
      flow_->output_.end(ticket_, ended && failure_ ? Result<int>(*failure_) : ended, took);
    }

   private:
    AsyncFlow* flow_;
    const Ticket ticket_;
    const Share share_;
    const gst::Ref<GstBuffer> buffer_;
    InputFrame in_;  // destroyed, and so unmapped, before the buffer
    OutputFrame out_;
    std::optional<Error> failure_;  // the error of the first output that could not be pushed
    const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  };

  // The engine reported something, or a frame was submitted. Any thread.
  void touch() {
    if (timeout_watch_) timeout_watch_->touch();
  }
  std::shared_ptr<const Use> use() const {
    std::lock_guard lock(mutex_);
    return use_;
  }
  // How many frames may be in progress.
  size_t depth() const { return std::max<size_t>(use()->model().info().max_in_flight, 1); }

  // Switches to the current model, but only once the previous one has answered all frames. Never
  // returns Full if `waits`.
  Result<FrameAdmission> follow_model(bool waits) {
    auto now = model_->lease().begin();
    if (!now) return now.error();
    const auto before = use();
    if (before && before->sessions_number() == now->sessions_number()) return FrameAdmission::Taken;
    if (before && !waits && before->session().requests().in_flight() > 0)
      return FrameAdmission::Full;
    if (before && !before->session().requests().wait_until_idle()) return FrameAdmission::Refused;
    std::lock_guard lock(mutex_);
    use_ = std::make_shared<const Use>(*std::move(now));
    return FrameAdmission::Taken;
  }

  // Whether the engine and max-bytes allow a frame of `bytes`; `share` then holds these bytes.
  Result<FrameAdmission> make_room(uint64_t bytes, Share* share) {
    auto followed = follow_model(output_.waits());
    if (!followed || *followed != FrameAdmission::Taken) return followed;
    auto& requests = use()->session().requests();
    if (!output_.waits() && requests.in_flight() >= depth()) return FrameAdmission::Full;
    if (!requests.wait_for_room()) return FrameAdmission::Refused;
    return infer::HeldBytes::take_frame(output_.held(), bytes, share);
  }

  // False while flushing. Then, and after an error, the frame was not started and the caller still
  // owns its ticket.
  Result<bool> submit(gst::Ref<GstBuffer> buffer, GstClockTime deadline, const Ticket& ticket,
                      Share share) {
    const auto held = use();
    auto frame = std::make_shared<Frame>(this, ticket, std::move(buffer), std::move(share));
    if (auto status = frame->read(*held, deadline); !status) return status.error();
    touch();
    return held->session().submit(frame->frame(), frame);
  }

  // Ends all frames in progress with an error. The flush or the stop cancels them, since an engine
  // that hangs may also hang in cancel(). False: the filter is not waiting for the engine.
  bool fail_on_timeout(std::chrono::milliseconds limit) {
    const auto held = use();
    const auto bytes = output_.held()->state();
    if (bytes.result_waits) return false;  // downstream blocks the engine
    if (!held || (!held->session().requests().has_waiting_receivers() && !bytes.frame_waits))
      return true;
    const auto in_flight = held->session().requests().in_flight();
    const Error error{.code = Code::WORKER_TIMEOUT,
                      .what = "the engine did not answer in time",
                      .offered = "async-timeout=" + std::to_string(limit.count()) +
                                 " ms, frames in progress: " + std::to_string(in_flight) +
                                 (bytes.frame_waits ? ", and one waits for max-bytes" : ""),
                      .needed = "an output or the end of a frame",
                      .fix = "tensor_filter invoke-async=true async-timeout=" +
                             std::to_string(10 * limit.count())};
    output_.fail_all(error);
    held->session().requests().fail(error);
    return true;
  }

  std::shared_ptr<const OpenModel> model_;  // streaming thread, like plan_; null before caps
  SharedFilterPlan plan_;
  mutable std::mutex mutex_;  // guards use_ against concurrent flushes
  // Held between frames: the engine may answer at any time.
  std::shared_ptr<const Use> use_;
  std::unique_ptr<IdleWatch> timeout_watch_;  // null: no limit; freed while no pad is active
};

}  // namespace

std::unique_ptr<FrameFlow> make_async_flow(const FrameFlow::Owner& owner,
                                           const FilterSettings& settings) {
  return std::make_unique<AsyncFlow>(owner, settings);
}

}  // namespace weir
