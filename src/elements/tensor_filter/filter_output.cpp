// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/filter_output.hpp"

#include <string>
#include <vector>

#include "elements/tensor_filter/admission.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/element/error.hpp"
#include "weir/abi.h"

namespace weir {
namespace {

GstFlowReturn to_flow(const Error& error) {
  return error.code == Code::NOT_NEGOTIATED ? GST_FLOW_NOT_NEGOTIATED : GST_FLOW_ERROR;
}
DropReason to_reason(GstFlowReturn flow) {
  if (flow == GST_FLOW_FLUSHING) return DropReason::Flush;
  return flow == GST_FLOW_EOS ? DropReason::Eos : DropReason::Error;
}

}  // namespace

infer::PoolLimits pool_limits(const FilterSettings& s) {
  infer::PoolLimits out{s.workers, infer::WhenBusy::Block, s.max_bytes};
  if (s.when_busy == WhenBusyChoice::DropNew) out.when_busy = infer::WhenBusy::DropNew;
  if (s.when_busy == WhenBusyChoice::DropOld) out.when_busy = infer::WhenBusy::DropOld;
  return out;
}

DropReason to_drop_reason(int result) noexcept {
  switch (result) {
    case WEIR_RESULT_LATE:
      return DropReason::Late;
    case WEIR_RESULT_REFUSED:
      return DropReason::Refused;
    case WEIR_RESULT_LOST:
      return DropReason::Lost;
    default:
      return DropReason::Policy;
  }
}

class FilterOutput::Waiting final : public infer::HeldBytes::Results {
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
  std::vector<Part> dropped_;  // freed without a lock because this may call the engine
};

FilterOutput::FilterOutput(const Owner& owner, const FilterSettings& settings, size_t depth,
                           bool with_task)
    : owner_(owner),
      when_busy_(pool_limits(settings).when_busy),
      held_(std::make_shared<infer::HeldBytes>(settings.max_bytes, when_busy_)),
      with_task_(with_task),
      queue_(depth) {
  task_.set(owner.source, [this] { drain(); });
  task_.open();
}

bool FilterOutput::is_past(GstClockTime deadline) const noexcept {
  return weir::is_past(owner_.element, deadline);
}

GstFlowReturn FilterOutput::reject(GstFlowReturn flow) {
  ledger()->dropped(to_reason(flow));
  return flow;
}

GstFlowReturn FilterOutput::reject(infer::HeldBytes::FrameAdmission admission) {
  if (admission == infer::HeldBytes::FrameAdmission::Refused)
    return reject(failed_ != GST_FLOW_OK && !flushing_ ? failed_.load() : GST_FLOW_FLUSHING);
  ledger()->dropped(DropReason::Policy);
  return report_flow();
}

GstFlowReturn FilterOutput::fail(const Error& error) {
  ledger()->dropped(DropReason::Error);
  gst::post_error(owner_.element, error);
  return to_flow(error);
}

GstFlowReturn FilterOutput::rejection() const noexcept {
  if (const GstFlowReturn failed = failed_; failed != GST_FLOW_OK) return failed;
  const GstFlowReturn flow = flow_;
  return flow == GST_FLOW_NOT_LINKED ? GST_FLOW_OK : flow;  // pads may be linked while frames flow
}

void FilterOutput::finish(const Ticket& ticket, Made made, DropReason reason) {
  if (made) {
    end(ticket, *std::move(made), reason);
    return;
  }
  if (!holds(ticket)) {  // the frame was flushed, so its error is ignored
    ledger()->dropped(DropReason::Flush);
    return;
  }
  ledger()->dropped(DropReason::Error);
  fail_all(made.error());
  skip(ticket);  // later entries, EOS for example, are pushed after the error was posted
}

GstFlowReturn FilterOutput::end(const Ticket& ticket, gst::Ref<GstBuffer> output,
                                DropReason reason) {
  if (!output) {
    ledger()->dropped(holds(ticket) ? reason : DropReason::Flush);
    skip(ticket);
    return GST_FLOW_OK;
  }
  if (!queue_.complete(ticket, std::move(output))) {
    ledger()->dropped(DropReason::Flush);
    return GST_FLOW_FLUSHING;
  }
  push_finished();
  return flow_;
}

void FilterOutput::drop_late(const Ticket& ticket) {
  ledger()->dropped(skip(ticket) ? DropReason::Qos : DropReason::Flush);
}

bool FilterOutput::skip(const Ticket& ticket) {
  if (!queue_.end(ticket)) return false;
  push_finished();
  return true;
}

Status FilterOutput::add(const Ticket& ticket, gst::Ref<GstBuffer> output) {
  const uint64_t bytes = gst_buffer_get_size(output.get());
  if (gst_buffer_n_memory(output.get()) == 0) {
    auto gap = gst::gap_like(output.get());
    if (gap && queue_.add(ticket, std::move(gap))) push_finished();
    return ok();
  }
  Waiting waiting(&queue_, ticket);
  const auto room = held_->take_result(bytes, waiting);
  if (room == infer::HeldBytes::Room::Taken) {
    if (queue_.add(ticket, Part{std::move(output), bytes}))
      push_finished();
    else
      held_->release_result(bytes);
  }
  if (room != infer::HeldBytes::Room::Stuck) return ok();
  const auto held = held_->state().held;
  const std::string max = std::to_string(held_->limit()), needed = std::to_string(held + bytes);
  return Error{.code = Code::LIMIT_EXCEEDED,
               .what = "outputs that wait for those of an older frame exceed max-bytes",
               .offered = std::to_string(held) + " bytes held and an output of " +
                          std::to_string(bytes) + " in addition, max-bytes=" + max,
               .needed = "max-bytes of " + needed +
                         " or more, or 0 for no limit; or when-busy=drop-new or drop-old",
               .fix = "tensor_filter invoke-async=true max-bytes=" + needed};
}

void FilterOutput::end(const Ticket& ticket, const Result<int>& ended,
                       std::chrono::nanoseconds took) {
  if (!ended) {
    finish(ticket, ended.error());
    return;
  }
  statistics()->record(took);
  check_latency();
  if (queue_.complete(ticket, Ended{*ended}))
    push_finished();
  else
    ledger()->dropped(DropReason::Flush);
}

void FilterOutput::fail_all(const Error& error) {
  auto none = GST_FLOW_OK;
  if (failed_.compare_exchange_strong(none, to_flow(error))) gst::post_error(owner_.element, error);
  held_->refuse_frames();
}

void FilterOutput::check_latency() noexcept {
  if (!reports_) return;
  const auto average = statistics()->latency_ns();
  if (average && report_.outdated(*average))
    gst_element_post_message(owner_.element,
                             gst_message_new_latency(GST_OBJECT_CAST(owner_.element)));
}

GstClockTime FilterOutput::report_latency() noexcept {
  return reports_ ? report_.update(statistics()->latency_ns().value_or(0)) : 0;
}

bool FilterOutput::send(gst::Ref<GstEvent> event) {
  event_taken_ = true;
  if (!queue_.append(std::move(event))) return false;
  push_finished();
  return event_taken_;
}

void FilterOutput::drain() {
  queue_.drain([this](Entry entry) { push(std::move(entry)); });
  if (with_task_) held_->moved();
}

void FilterOutput::push(Entry entry) noexcept {
  if (auto* buffer = std::get_if<gst::Ref<GstBuffer>>(&entry)) {
    if (gst_buffer_n_memory(buffer->get()) == 0) return push_gap(buffer->get());
    ledger()->consumed_and_pushed();
    const GstFlowReturn flow = gst_pad_push(owner_.source, buffer->release());
    if (flow != flow_) flow_is_reported_ = false;
    flow_ = flow;
  } else if (auto* event = std::get_if<gst::Ref<GstEvent>>(&entry)) {
    if (GST_EVENT_TYPE(event->get()) == GST_EVENT_EOS) post_flow();
    event_taken_ = gst_pad_push_event(owner_.source, event->release());
  } else if (auto* part = std::get_if<Part>(&entry)) {
    ledger()->pushed();
    flow_ = gst_pad_push(owner_.source, part->buffer.release());
    held_->release_result(part->bytes);
  } else {
    const auto reason = to_drop_reason(std::get<Ended>(entry).reason);
    if (reason == DropReason::Policy)  // an engine may have no output for a frame
      ledger()->consumed();
    else
      ledger()->dropped(reason);
  }
}

void FilterOutput::push_gap(GstBuffer* frame) noexcept {
  ledger()->dropped(DropReason::Policy);
  if (auto gap = gst::gap_like(frame)) gst_pad_push_event(owner_.source, gap.release());
}

// Like GStreamer's queues: upstream gets no flow return after EOS, so a failed push must be posted.
void FilterOutput::post_flow() noexcept {
  const GstFlowReturn flow = flow_;
  const bool failed = flow == GST_FLOW_NOT_LINKED || flow < GST_FLOW_EOS;
  if (!failed || flow_is_reported_) return;
  const auto element = gst::Ref<GstElement>::adopt(gst_pad_get_parent_element(owner_.source));
  if (element) GST_ELEMENT_FLOW_ERROR(element.get(), flow);
}

void FilterOutput::reject_frames() {
  flushing_ = true;
  held_->refuse();
}

void FilterOutput::flush() {
  reject_frames();
  for (const Entry& entry : queue_.flush()) {
    if (std::holds_alternative<gst::Ref<GstBuffer>>(entry) || std::holds_alternative<Ended>(entry))
      ledger()->dropped(DropReason::Flush);
    if (const auto* part = std::get_if<Part>(&entry)) held_->release_result(part->bytes);
  }
}

void FilterOutput::resume() {
  queue_.resume();
  flow_ = failed_ = GST_FLOW_OK;
  held_->resume();
  flushing_ = false;
}

void FilterOutput::add_stats(GstStructure* stats, infer::PoolState pool) const {
  const auto s = statistics()->snapshot();
  gst_structure_set(stats, "invokes", G_TYPE_UINT64, s.count, "last-us", G_TYPE_DOUBLE, s.last_us,
                    "average-us", G_TYPE_DOUBLE, s.average_us, "p99-us", G_TYPE_DOUBLE, s.p99_us,
                    "pool-allocated", G_TYPE_UINT64, pool_allocated_.load(), nullptr);
  if (with_task_) {
    const auto held = held_->state();
    pool.bytes_held = held.held, pool.bytes_peak = held.peak;
    gst_structure_set(stats, "outputs-dropped", G_TYPE_UINT64, held.dropped, nullptr);
  }
  gst_structure_set(stats, "workers", G_TYPE_UINT64, uint64_t{pool.workers}, "workers-busy",
                    G_TYPE_UINT64, uint64_t{pool.busy}, "mean-busy", G_TYPE_DOUBLE, pool.mean_busy,
                    "waiting", G_TYPE_UINT64, uint64_t{pool.waiting}, "bytes-held", G_TYPE_UINT64,
                    pool.bytes_held, "bytes-most", G_TYPE_UINT64, pool.bytes_peak, nullptr);
}

}  // namespace weir
