// Frames of an engine that answers on its own threads.
#include <string>

#include "elements/tensor_filter/deadline.hpp"
#include "elements/tensor_filter/frame_flow.hpp"

namespace weir {

GstFlowReturn FrameFlow::take_async(gst::Ref<GstBuffer> buffer, GstClockTime deadline) {
  if (const GstFlowReturn flow = refusal(); flow != GST_FLOW_OK) return refuse(flow);
  using Answer = infer::HeldBytes::Answer;
  const auto ticket = waits_ ? queue_.submit() : queue_.try_submit();
  if (!ticket) return give_up(waits_ || flushing_ ? Answer::Refused : Answer::Full);
  infer::HeldBytes::Share share;
  const auto room = async_.make_room(waits_, held_, gst_buffer_get_size(buffer.get()), &share);
  if (!room || *room != Answer::Taken) {
    queue_.skip(*ticket);
    return room ? give_up(*room) : fail(room.error());
  }
  if (is_past(element_, deadline)) {
    drop_late(*ticket);
    return GST_FLOW_OK;
  }
  const auto begun = async_.submit(std::move(buffer), deadline, *ticket, std::move(share));
  if (begun && *begun) return queue_.tell_flow();
  queue_.skip(*ticket);
  return begun ? give_up(Answer::Refused) : fail(begun.error());
}

GstFlowReturn FrameFlow::give_up(infer::HeldBytes::Answer answer) {
  if (answer == infer::HeldBytes::Answer::Refused)
    return refuse(failed_ != GST_FLOW_OK && !flushing_ ? failed_.load() : GST_FLOW_FLUSHING);
  ledger_->dropped(DropReason::Policy);
  return queue_.tell_flow();
}

Status FrameFlow::add(const Ticket& ticket, gst::Ref<GstBuffer> output) {
  const uint64_t bytes = gst_buffer_get_size(output.get());
  if (queue_.add(ticket, std::move(output)) != infer::HeldBytes::Room::Stuck) return ok();
  const auto held = held_->state().held;
  const std::string most = std::to_string(held_->limit()), needed = std::to_string(held + bytes);
  return Error{Code::LIMIT_EXCEEDED,
               "outputs that wait for those of an older frame are more bytes than max-bytes allows",
               std::to_string(held) + " bytes held and an output of " + std::to_string(bytes) +
                   " beside them, max-bytes=" + most,
               "max-bytes of " + needed + " or more, 0 = any; or when-busy=drop-new or drop-old",
               "",
               "tensor_filter invoke-async=true max-bytes=" + needed};
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
