// Pushes what is finished, in order.
#include "elements/tensor_filter/output_queue.hpp"

#include <vector>

namespace weir {

void OutputQueue::set_pad(GstPad* source) {
  source_ = source;
  task_.set(source, [this] { drain(); });
}

class OutputQueue::Waiting final : public infer::HeldBytes::Results {
 public:
  Waiting(Queue* queue, const Ticket& ticket) : queue_(queue), ticket_(ticket) {}
  bool leave() const override { return queue_->leaves(); }
  bool is_next() const override { return queue_->is_next(ticket_); }
  std::optional<uint64_t> drop_oldest() override {
    auto entry =
        queue_->take_oldest([](const Entry& e) { return std::holds_alternative<Part>(e); });
    if (!entry) return std::nullopt;
    dropped_.push_back(std::get<Part>(*std::move(entry)));
    return dropped_.back().bytes;
  }

 private:
  Queue* queue_;
  const Ticket& ticket_;
  std::vector<Part> dropped_;  // freed without a lock: the engine may hear of its memory
};

void OutputQueue::open(bool with_task, std::shared_ptr<infer::HeldBytes> held) {
  held_ = std::move(held);
  with_task_ = with_task;
  task_.open();
}

GstFlowReturn OutputQueue::finish(const Ticket& ticket, gst::Ref<GstBuffer> output) {
  if (!queue_.complete(ticket, std::move(output))) {
    ledger_->dropped(DropReason::Flush);
    return GST_FLOW_FLUSHING;
  }
  push_finished();
  return flow_;
}

infer::HeldBytes::Room OutputQueue::add(const Ticket& ticket, gst::Ref<GstBuffer> output) {
  const uint64_t bytes = gst_buffer_get_size(output.get());
  Waiting waiting(&queue_, ticket);
  const auto room = held_->take_result(bytes, waiting);
  if (room != infer::HeldBytes::Room::Taken) return room;
  if (queue_.add(ticket, Part{std::move(output), bytes}))
    push_finished();
  else
    held_->release_result(bytes);
  return room;
}

void OutputQueue::end(const Ticket& ticket) {
  if (queue_.complete(ticket, Ended{}))
    push_finished();
  else
    ledger_->dropped(DropReason::Flush);
}

bool OutputQueue::skip(const Ticket& ticket) {
  if (!queue_.end(ticket)) return false;
  push_finished();
  return true;
}

bool OutputQueue::send(gst::Ref<GstEvent> event) {
  event_taken_ = true;
  if (!queue_.append(std::move(event))) return false;
  push_finished();
  return event_taken_;
}

void OutputQueue::flush() {
  for (const Entry& entry : queue_.flush()) {
    if (std::holds_alternative<gst::Ref<GstBuffer>>(entry) || std::holds_alternative<Ended>(entry))
      ledger_->dropped(DropReason::Flush);
    if (const auto* part = std::get_if<Part>(&entry)) held_->release_result(part->bytes);
  }
}

void OutputQueue::resume() {
  queue_.resume();
  flow_ = GST_FLOW_OK;
}

void OutputQueue::push_finished() {
  with_task_ ? task_.wake() : drain();
}

void OutputQueue::drain() {
  queue_.drain([this](Entry entry) { push(std::move(entry)); });
  if (with_task_) held_->moved();
}

void OutputQueue::push(Entry entry) noexcept {
  if (auto* buffer = std::get_if<gst::Ref<GstBuffer>>(&entry)) {
    ledger_->consumed_and_pushed();
    const GstFlowReturn flow = gst_pad_push(source_, buffer->release());
    if (flow != flow_) flow_is_told_ = false;
    flow_ = flow;
  } else if (auto* event = std::get_if<gst::Ref<GstEvent>>(&entry)) {
    if (GST_EVENT_TYPE(event->get()) == GST_EVENT_EOS) post_flow();
    event_taken_ = gst_pad_push_event(source_, event->release());
  } else if (auto* part = std::get_if<Part>(&entry)) {
    ledger_->pushed();
    flow_ = gst_pad_push(source_, part->buffer.release());
    held_->release_result(part->bytes);
  } else {
    ledger_->consumed();
  }
}

// As GStreamer's queues do: who brought the frames has gone on and will not ask any more.
void OutputQueue::post_flow() noexcept {
  const GstFlowReturn flow = flow_;
  const bool failed = flow == GST_FLOW_NOT_LINKED || flow < GST_FLOW_EOS;
  if (!failed || flow_is_told_) return;
  const auto element = gst::Ref<GstElement>::adopt(gst_pad_get_parent_element(source_));
  if (element) GST_ELEMENT_FLOW_ERROR(element.get(), flow);
}

}  // namespace weir
