// PendingRequests: the frames that a query client has sent and that have no answer yet
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
#include <vector>

#include "core/isolate/deadline.hpp"
#include "core/wire/peer_error.hpp"
#include "weir/result.hpp"

namespace weir::edge {

// Messages of NNStreamer have no numbers: the n-th answer of a connection belongs to its n-th
// request. A request that timed out frees its place, but its entry stays without a frame, so that a
// late answer is not taken for the answer of the next request. Servers of Weir repeat the number of
// the request (`weir.seq`); then no such entries are needed. One thread at a time.
template <class Frame>
class PendingRequests {
 public:
  // `max_request`: the property of the client.
  explicit PendingRequests(size_t max_request) : max_request_(max_request) {}

  // Whether a further request may be sent: as in NNStreamer, while no more than `max_request` wait.
  bool has_room() const noexcept { return waiting() <= max_request_; }
  // A request was sent; returns its number. Without `deadline` it waits until the connection ends.
  uint64_t add(Frame frame, isolate::Deadline deadline) {
    entries_.push_back({next_, std::move(frame), deadline});
    return next_++;
  }

  // An answer arrived, with the number that the server repeated, if it did. Returns the frame that
  // asked; nullopt if that request timed out. PEER_MESSAGE_INVALID for an answer without a request,
  // and for one without a number from a server that sent numbers before.
  Result<std::optional<Frame>> accept(std::optional<uint64_t> number) {
    if (number) return accept_number(*number);
    if (numbered_)
      return wire::peer_error("an answer has no weir.seq", "an answer without a number",
                              "the number of its request, as in earlier answers");
    if (entries_.empty())
      return wire::peer_error("an answer belongs to no request", "one answer more than requests",
                              "one answer for each request");
    return remove(entries_.begin());
  }

  // Removes the frames whose deadline is not after `now` and returns them, oldest first.
  std::vector<Frame> expire(std::chrono::steady_clock::time_point now) {
    std::vector<Frame> late;
    for (Entry& entry : entries_) {
      if (!entry.frame || !entry.deadline || *entry.deadline > now) continue;
      late.push_back(*std::exchange(entry.frame, std::nullopt));
    }
    if (numbered_) drop_expired();
    return late;
  }
  // Whether more than `max_request` requests have timed out and are still without an answer. The
  // server may have dropped their frames: only a new connection makes clear which answer is whose.
  bool must_reconnect() const noexcept { return entries_.size() - waiting() > max_request_; }

  // The connection ended: no answer will come. Returns the frames that wait, oldest first. Numbers
  // of requests continue.
  std::vector<Frame> clear() {
    std::vector<Frame> lost;
    for (Entry& entry : entries_)
      if (entry.frame) lost.push_back(*std::move(entry.frame));
    entries_.clear();
    numbered_ = false;
    first_ = next_;
    return lost;
  }

  // Requests that wait for an answer.
  size_t waiting() const noexcept {
    return static_cast<size_t>(std::count_if(entries_.begin(), entries_.end(),
                                             [](const Entry& e) { return e.frame.has_value(); }));
  }
  // When the next request times out.
  isolate::Deadline next_deadline() const {
    isolate::Deadline next;
    for (const Entry& entry : entries_)
      if (entry.frame && entry.deadline && (!next || *entry.deadline < *next))
        next = entry.deadline;
    return next;
  }

 private:
  struct Entry {
    uint64_t number;
    std::optional<Frame> frame;  // none: it timed out
    isolate::Deadline deadline;
  };
  using Entries = std::deque<Entry>;

  Result<std::optional<Frame>> accept_number(uint64_t number) {
    if (number < first_ || number >= next_)
      return wire::peer_error("an answer belongs to no request",
                              "weir.seq " + std::to_string(number),
                              "a number that was sent on this connection");
    numbered_ = true;
    drop_expired();
    const auto found = std::find_if(entries_.begin(), entries_.end(),
                                    [&](const Entry& e) { return e.number == number; });
    if (found == entries_.end()) return std::optional<Frame>();
    return remove(found);
  }
  std::optional<Frame> remove(typename Entries::iterator entry) {
    auto frame = std::move(entry->frame);
    entries_.erase(entry);
    return frame;
  }
  void drop_expired() {
    std::erase_if(entries_, [](const Entry& e) { return !e.frame; });
  }

  const size_t max_request_;
  Entries entries_;        // in the order in which they were sent
  uint64_t next_ = 0;      // number of the next request
  uint64_t first_ = 0;     // number of the first request of this connection
  bool numbered_ = false;  // the server repeats numbers
};

}  // namespace weir::edge
