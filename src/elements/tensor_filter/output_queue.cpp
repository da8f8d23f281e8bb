// Pushes what is finished, in order.
#include "elements/tensor_filter/output_queue.hpp"

namespace weir {

GstFlowReturn OutputQueue::finish(const Ticket& ticket, gst::Ref<GstBuffer> output) {
  if (!queue_.complete(ticket, std::move(output))) {
    ledger_->dropped(DropReason::Flush);
    return GST_FLOW_FLUSHING;
  }
  push_finished();
  return flow_;
}

void OutputQueue::skip(const Ticket& ticket) {
  queue_.complete(ticket, std::monostate{});
  push_finished();
}

bool OutputQueue::send(gst::Ref<GstEvent> event) {
  event_taken_ = true;
  if (!queue_.append(std::move(event))) return false;
  push_finished();
  return event_taken_;
}

void OutputQueue::flush() {
  for (const Entry& entry : queue_.flush())
    if (std::holds_alternative<gst::Ref<GstBuffer>>(entry)) ledger_->dropped(DropReason::Flush);
}

void OutputQueue::resume() {
  queue_.resume();
  flow_ = GST_FLOW_OK;
}

void OutputQueue::push_finished() {
  queue_.drain([this](Entry entry) { push(std::move(entry)); });
}

void OutputQueue::push(Entry entry) noexcept {
  if (auto* buffer = std::get_if<gst::Ref<GstBuffer>>(&entry)) {
    ledger_->consumed_and_pushed();
    flow_ = gst_pad_push(source_, buffer->release());
  } else if (auto* event = std::get_if<gst::Ref<GstEvent>>(&entry)) {
    event_taken_ = gst_pad_push_event(source_, event->release());
  }
}

}  // namespace weir
