// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/tensor_query_client/query_exchange.hpp"

#include <utility>

#include "core/wire/peer_error.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"

namespace weir {
namespace {

using edge::LinkEnd;

// A server that drops a frame now and then.
constexpr size_t kMinTimeOutsInARow = 2;

gboolean remove_meta_of_memory(GstBuffer*, GstMeta** meta, gpointer) {
  static const GQuark memory = g_quark_from_static_string(GST_META_TAG_MEMORY_STR);
  if (gst_meta_api_type_has_tag((*meta)->info->api, memory)) *meta = nullptr;
  return TRUE;
}

// Times, flags and metas of a buffer without its memories. What describes the memories, as the
// planes of video, would be wrong for those of the response.
gst::Ref<GstBuffer> like(GstBuffer* buffer) {
  auto out = gst::Ref<GstBuffer>::adopt(gst_buffer_new());
  gst_buffer_copy_into(out.get(), buffer, GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
  gst_buffer_foreach_meta(out.get(), remove_meta_of_memory, nullptr);
  return out;
}

}  // namespace

void QueryExchange::open(std::unique_ptr<edge::QueryLink> link, const GstCaps* input,
                         const GstCaps* output) {
  link_ = std::move(link);
  was_refused_ = false;
  input_.set_caps(input);
  output_.set_caps(output);
  const auto spec = gst::fixed_spec_from_caps(output);
  has_tensors_ = spec.has_value();
  if (spec) spec_ = *spec;
}

void QueryExchange::close(DropReason reason) {
  link_.reset();
  const auto ended = pending_.clear();
  ledger_->dropped(reason, ended.waiting);
  ledger_->dropped(DropReason::Late, ended.expired);
  if (was_refused_)
    outcomes_->refused(ended.waiting);
  else
    outcomes_->lost(ended.waiting);
}

Result<std::optional<LinkEnd>> QueryExchange::send(GstBuffer* buffer,
                                                   std::chrono::milliseconds time) {
  const auto mapped = input_.map(buffer);
  if (!mapped) {
    ledger_->dropped(DropReason::Error);
    return mapped.error();
  }
  const auto request = link_->make_request(mapped->memories, pending_.next_number());
  if (!request) {
    ledger_->dropped(DropReason::Error);
    return request.error();
  }
  const auto forgotten =
      pending_.add({like(buffer), std::chrono::steady_clock::now()}, io::deadline_in(time));
  ledger_->dropped(DropReason::Late, forgotten);
  outcomes_->sent();
  const auto ended = link_->send(*request);
  if (ended) was_refused_ = *ended == LinkEnd::Refused;
  return ended;
}

Result<ExchangeEvent> QueryExchange::next(bool wait, size_t max_request) {
  for (;;) {
    outcomes_->late(pending_.expire(std::chrono::steady_clock::now()));
    if (auto answered = pending_.take()) return finish(std::move(*answered));
    if (pending_.must_reconnect(std::max(max_request, kMinTimeOutsInARow)))
      return ExchangeEvent{{}, LinkEnd::OutOfStep};
    if (wait && pending_.waiting() == 0) return ExchangeEvent{{}, LinkEnd::Late};
    const auto ended = receive(wait);
    if (!ended) return ended.error();
    if (*ended) return ExchangeEvent{{}, *ended};
  }
}

// Takes the next response from the link; nullopt if the next request may have got one or timed out.
Result<std::optional<LinkEnd>> QueryExchange::receive(bool wait) {
  auto received =
      link_->receive(wait ? pending_.next_deadline() : std::chrono::steady_clock::now());
  if (!received) return received.error();
  if (received->response) {
    const auto number = received->response->number;
    auto status = pending_.accept(number, *std::move(received->response));
    if (!status) return status.error();
    return std::optional<LinkEnd>();
  }
  was_refused_ = received->end == LinkEnd::Refused;
  if (wait && received->end == LinkEnd::Late) return std::optional<LinkEnd>();
  return received->end;
}

Status QueryExchange::check_count(size_t memories) const {
  const size_t tensors = spec_.tensors.size();
  if (!has_tensors_ || spec_.format != Format::Static || memories <= tensors) return ok();
  return wire::peer_error("too many memories", std::to_string(memories) + " memories",
                          "one for each of " + std::to_string(tensors) + " tensors");
}

Result<ExchangeEvent> QueryExchange::finish(Pending::Answered answered) {
  ledger_->dropped(DropReason::Late, pending_.take_skipped());
  uint64_t copied = 0;
  Status status = check_count(answered.response.memories.size());
  auto buffer = output_.make(std::move(answered.response.memories), &copied);
  if (status && !buffer) status = buffer.error();
  if (status && has_tensors_) status = layout_.locate(buffer->get(), spec_);
  if (!status) {
    ledger_->dropped(DropReason::Error);
    if (!answered.late) outcomes_->lost(1);
    return wire::peer_error("an answer does not fit the caps that the server announced",
                            status.error().what + ": " + status.error().offered,
                            status.error().needed, "check the pipeline of the server");
  }
  ledger_->copied(copied);
  outcomes_->answered(std::chrono::steady_clock::now() - answered.frame.sent, answered.late);
  gst_buffer_copy_into(buffer->get(), answered.frame.like.get(), GST_BUFFER_COPY_METADATA, 0,
                       static_cast<gsize>(-1));
  ledger_->consumed_and_pushed();
  return ExchangeEvent{*std::move(buffer), {}};
}

}  // namespace weir
