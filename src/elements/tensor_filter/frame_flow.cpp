// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/frame_flow.hpp"

#include "gstcpp/element/error.hpp"

namespace weir {

std::unique_ptr<FrameFlow> FrameFlow::make(const Owner& owner, const FilterSettings& s) {
  if (s.invoke_async) return make_async_flow(owner, s);
  if (s.batch_size > 1) return make_batch_flow(owner, s);
  const bool has_workers = s.workers > 1 || s.when_busy != WhenBusyChoice::Unset;
  return has_workers ? make_workers_flow(owner, s) : make_inline_flow(owner, s);
}

bool FrameFlow::send(gst::Ref<GstEvent> event) {
  const auto type = GST_EVENT_TYPE(event.get());
  if (type == GST_EVENT_EOS || type == GST_EVENT_GAP) pause();
  return output_.send(std::move(event));
}

void FrameFlow::stop() {
  flush();
  output_.stop();
}

FrameFlow::Delay FrameFlow::report_latency() {
  const Delay wait = delay();
  const GstClockTime invoke = output_.report_latency();
  return {invoke + wait.min, invoke + wait.max};
}

GstFlowReturn FrameFlow::reject_before_caps() {
  return output_.fail(gst::buffer_before_caps());
}

infer::PoolState FrameFlow::pool_state() const {
  infer::PoolState state;
  state.workers = 1;
  state.busy = static_cast<size_t>(output_.ledger()->snapshot().held());
  return state;
}

}  // namespace weir
