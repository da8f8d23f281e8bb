// Frames of an engine that answers on its own threads.
#include "elements/tensor_filter/deadline.hpp"
#include "elements/tensor_filter/frame_flow.hpp"

namespace weir {

GstFlowReturn FrameFlow::take_async(gst::Ref<GstBuffer> buffer, GstClockTime deadline) {
  if (const GstFlowReturn flow = refusal(); flow != GST_FLOW_OK) return refuse(flow);
  const auto ticket = queue_.submit();
  const auto flushed = [&] {
    if (ticket) queue_.skip(*ticket);
    return refuse(failed_ != GST_FLOW_OK && !flushing_ ? failed_.load() : GST_FLOW_FLUSHING);
  };
  if (!ticket) return flushed();
  const auto room = async_.wait_for_room();
  if (room && !*room) return flushed();
  if (!room) {
    queue_.skip(*ticket);
    return fail(room.error());
  }
  if (is_past(element_, deadline)) {
    drop_late(*ticket);
    return GST_FLOW_OK;
  }
  const auto begun = async_.submit(std::move(buffer), deadline, *ticket);
  if (begun) return *begun ? queue_.tell_flow() : flushed();
  queue_.skip(*ticket);
  return fail(begun.error());
}

void FrameFlow::end(const Ticket& ticket, const Status& status, std::chrono::nanoseconds took) {
  if (!status) {
    finish(ticket, status.error());
    return;
  }
  statistics_.record(took);
  check_latency();
  queue_.end(ticket);
}

}  // namespace weir
