// PendingRequests: the requests of a query client that have no response yet
// (docs/compatibility/edge-wire.md 10.3, 10.4).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>

#include "core/io/deadline.hpp"
#include "core/wire/peer_error.hpp"
#include "weir/result.hpp"

namespace weir::edge {

// `Frame` is what the client keeps of a frame that it sent.
//
// Messages of NNStreamer have no numbers: the n-th response of a connection belongs to its n-th
// request. A request that timed out frees its place. Its response is still used if it arrives
// before the next request is sent; afterwards nothing could say which of the two it answers, so the
// entry stays without its frame until a response has been discarded for it. Servers of Weir repeat
// the number of the request (`weir.seq`) and may answer in any order; take() returns the responses
// in the order of the requests. One thread at a time.
template <class Frame, class Response>
class PendingRequests {
 public:
  using Time = std::chrono::steady_clock::time_point;

  // Whether a further request may be sent: as in NNStreamer, while no more than `max_request` wait;
  // 0 = no limit.
  bool has_room(size_t max_request) const noexcept {
    return max_request == 0 || waiting() <= max_request;
  }
  // The number of the next request.
  uint64_t next_number() const noexcept { return next_; }
  // A request was sent. Without `deadline` it waits until the connection ends. Returns how many
  // requests that timed out can no longer have a response because of it.
  size_t add(Frame frame, io::Deadline deadline) {
    size_t forgotten = 0;
    for (Entry& entry : entries_) {
      if (!entry.expired || !entry.frame) continue;
      entry.frame.reset();
      ++forgotten;
    }
    if (numbered_) std::erase_if(entries_, [](const Entry& e) { return !e.frame; });
    entries_.push_back({next_++, std::move(frame), {}, deadline, false});
    return forgotten;
  }

  // A response arrived, with the number that the server repeated, if it did. PEER_MESSAGE_INVALID
  // for a response without a request, and for one without a number from a server that sent numbers
  // before.
  Status accept(std::optional<uint64_t> number, Response response) {
    if (number) return accept_number(*number, std::move(response));
    if (numbered_)
      return wire::peer_error("an answer has no weir.seq", "an answer without a number",
                              "the number of its request, as in earlier answers");
    const auto entry =
        std::find_if(entries_.begin(), entries_.end(), [](const Entry& e) { return !e.response; });
    if (entry == entries_.end())
      return wire::peer_error("an answer does not belong to a request",
                              "more answers than requests", "one answer for each request");
    if (entry->frame)
      answered(&*entry, std::move(response));
    else
      entries_.erase(entry);
    return ok();
  }

  struct Answered {
    Frame frame;
    Response response;
    bool late;  // after its deadline
  };
  // The next answered request, in the order in which requests were sent. With numbers, requests
  // that have timed out are skipped.
  std::optional<Answered> take() {
    const auto found = std::find_if(entries_.begin(), entries_.end(), [this](const Entry& e) {
      return e.response || !numbered_ || !e.expired;
    });
    if (found == entries_.end() || !found->response) return std::nullopt;
    Answered out{*std::move(found->frame), *std::move(found->response), found->expired};
    skipped_ += static_cast<size_t>(
        std::count_if(entries_.begin(), found, [](const Entry& e) { return e.frame.has_value(); }));
    entries_.erase(entries_.begin(), found + 1);
    return out;
  }
  // Requests that timed out and were skipped by take(), since the last call.
  size_t take_skipped() noexcept { return std::exchange(skipped_, 0); }

  // Frees the places of the requests whose deadline is not after `now`; returns how many.
  size_t expire(Time now) {
    size_t count = 0;
    for (Entry& entry : entries_) {
      if (entry.expired || entry.response || !entry.deadline || *entry.deadline > now) continue;
      entry.expired = true;
      ++count;
    }
    late_in_row_ += count;
    return count;
  }
  // Whether more than `max` requests in a row have timed out. The server may have dropped frames:
  // only a new connection makes clear which response is whose. With numbers it always is.
  bool must_reconnect(size_t max) const noexcept { return !numbered_ && late_in_row_ > max; }

  struct Ended {
    size_t waiting = 0;  // they had time left
    size_t expired = 0;  // their response could still have come
  };
  // The connection ended: no response will come. Numbers of requests continue.
  Ended clear() {
    Ended out;
    for (const Entry& entry : entries_) {
      if (!entry.expired) ++out.waiting;
      if (entry.expired && entry.frame) ++out.expired;
    }
    entries_.clear();
    numbered_ = false;
    late_in_row_ = 0;
    first_ = next_;
    return out;
  }

  // Requests that have a place: without a response, and not timed out.
  size_t waiting() const noexcept {
    return static_cast<size_t>(
        std::count_if(entries_.begin(), entries_.end(), [](const Entry& e) { return e.waits(); }));
  }
  // When the next request times out.
  io::Deadline next_deadline() const {
    io::Deadline next;
    for (const Entry& entry : entries_)
      if (entry.waits()) next = io::earlier(next, entry.deadline);
    return next;
  }

 private:
  struct Entry {
    uint64_t number;
    std::optional<Frame> frame;  // none: no response can be used
    std::optional<Response> response;
    io::Deadline deadline;
    bool expired;

    bool waits() const noexcept { return !expired && !response; }
  };

  void answered(Entry* entry, Response response) {
    entry->response = std::move(response);
    late_in_row_ = 0;
  }
  Status accept_number(uint64_t number, Response response) {
    if (number < first_ || number >= next_)
      return wire::peer_error("an answer does not belong to a request",
                              "weir.seq " + std::to_string(number),
                              "a number that was sent on this connection");
    numbered_ = true;
    std::erase_if(entries_, [](const Entry& e) { return !e.frame; });
    const auto found = std::find_if(entries_.begin(), entries_.end(),
                                    [&](const Entry& e) { return e.number == number; });
    if (found != entries_.end() && !found->response) answered(&*found, std::move(response));
    return ok();
  }

  std::deque<Entry> entries_;  // in the order in which they were sent
  uint64_t next_ = 0;          // number of the next request
  uint64_t first_ = 0;         // number of the first request of this connection
  bool numbered_ = false;      // the server repeats numbers
  size_t late_in_row_ = 0, skipped_ = 0;
};

}  // namespace weir::edge
