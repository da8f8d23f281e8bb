// InlineFlow: processes frames on the streaming thread, one at a time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/frame_flow.hpp"
#include "elements/tensor_filter/frame_invoker.hpp"

namespace weir {
namespace {

class InlineFlow final : public FrameFlow {
 public:
  InlineFlow(const Owner& owner, const FilterSettings& settings)
      : FrameFlow(owner, settings, 1, false) {}

  Status begin(std::shared_ptr<const OpenModel> model, SharedFilterPlan plan) override {
    auto invoker = std::make_unique<FrameInvoker>(std::move(model), 0, std::move(plan), &output_);
    if (auto status = invoker->prepare(); !status) return status;
    invoker_ = std::move(invoker);
    return ok();
  }

  GstFlowReturn push(gst::Ref<GstBuffer> buffer, GstClockTime deadline) override {
    if (!invoker_) return reject_before_caps();
    const auto ticket = output_.submit();
    if (!ticket) return output_.reject(GST_FLOW_FLUSHING);
    if (output_.is_past(deadline)) {
      output_.drop_late(*ticket);
      return GST_FLOW_OK;
    }
    auto use = invoker_->model().lease().begin();
    auto made = use ? invoker_->run(*std::move(use), buffer.get(), deadline)
                    : FilterOutput::Made(use.error());
    output_.check_latency();
    if (made) {
      const GstFlowReturn flow = output_.end(*ticket, *std::move(made), invoker_->drop_reason());
      if (flow != GST_FLOW_OK) output_.report_flow();
      return flow;
    }
    if (!output_.holds(*ticket))
      return output_.reject(GST_FLOW_FLUSHING);  // the frame was flushed, so its error is ignored
    output_.skip(*ticket);
    return output_.fail(made.error());
  }

  void close() override {
    FrameFlow::close();
    invoker_.reset();
  }

 private:
  std::unique_ptr<FrameInvoker> invoker_;  // null before caps
};

}  // namespace

std::unique_ptr<FrameFlow> make_inline_flow(const FrameFlow::Owner& owner,
                                            const FilterSettings& settings) {
  return std::make_unique<InlineFlow>(owner, settings);
}

}  // namespace weir
