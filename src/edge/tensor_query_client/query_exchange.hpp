// QueryExchange: frames that go to a query server as buffers, and responses that come back as such.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <chrono>
#include <memory>
#include <optional>

#include "core/ledger/ledger.hpp"
#include "edge/message_buffer.hpp"
#include "edge/message_memories.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "transport/edge/pending_requests.hpp"
#include "transport/edge/query_link.hpp"
#include "transport/edge/request_outcomes.hpp"

namespace weir {

// What comes next of a connection.
struct ExchangeEvent {
  gst::Ref<GstBuffer> response{};      // with the times and metas of the frame that asked
  std::optional<edge::LinkEnd> end{};  // instead; Late: no response is there, or none is waited for
};

// Counts each frame in `ledger` and `outcomes`. One thread at a time.
class QueryExchange {
 public:
  QueryExchange(Ledger* ledger, edge::RequestOutcomes* outcomes)
      : ledger_(ledger), outcomes_(outcomes) {}

  bool is_connected() const noexcept { return link_ != nullptr; }
  // `link` is confirmed, `input` and `output` are the caps of frames and responses.
  void open(std::unique_ptr<edge::QueryLink> link, const GstCaps* input, const GstCaps* output);
  // Ends the connection, if there is one. Frames without a response are dropped for `reason`.
  void close(DropReason reason);

  bool has_room(size_t max_request) const noexcept { return pending_.has_room(max_request); }
  size_t waiting() const noexcept { return pending_.waiting(); }
  // Sends a frame that has been received; its response has `time` to come. Returns why the
  // connection has ended, if it has. Errors: those of MemoryMapper::map(),
  // edge::QueryLink::make_request(), then the frame is dropped; and those of
  // edge::QueryLink::send().
  Result<std::optional<edge::LinkEnd>> send(GstBuffer* buffer, std::chrono::milliseconds time);
  // The next response. With `wait` it waits until each request has its response or has timed out.
  // PEER_MESSAGE_INVALID.
  Result<ExchangeEvent> next(bool wait, size_t max_request);

 private:
  struct Frame {
    gst::Ref<GstBuffer> like;  // times, flags and metas
    std::chrono::steady_clock::time_point sent;
  };
  using Pending = edge::PendingRequests<Frame, edge::QueryResponse>;

  Result<std::optional<edge::LinkEnd>> receive(bool wait);
  Status check_count(size_t memories) const;
  Result<ExchangeEvent> finish(Pending::Answered answered);

  Ledger* const ledger_;
  edge::RequestOutcomes* const outcomes_;
  std::unique_ptr<edge::QueryLink> link_;
  Pending pending_;
  bool was_refused_ = false;
  MemoryMapper input_;
  MessageBuffers output_;
  bool has_tensors_ = false;
  FrameSpec spec_;
  gst::FrameLayout layout_;  // of responses that are tensors
};

}  // namespace weir
