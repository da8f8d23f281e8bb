// Call: a call of a client to this server. Every call ends once.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <string_view>

#include "net/protocol/oip_messages.hpp"
#include "net/protocol/outcome.hpp"

namespace weir::net {

// Whether this is a `traceparent` as W3C's Trace Context defines it: VERSION-TRACE-SPAN-FLAGS, all
// of them lower-case hexadecimal digits.
inline bool is_trace_parent(std::string_view text) {
  constexpr std::string_view kForm = "xx-xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx-xxxxxxxxxxxxxxxx-xx";
  constexpr std::string_view kDigits = "0123456789abcdef";
  return std::equal(text.begin(), text.end(), kForm.begin(), kForm.end(), [&](char c, char form) {
    return form == 'x' ? kDigits.find(c) != std::string_view::npos : c == form;
  });
}

// Thread-safe. A call that is not ended when its last reference goes ends as ABORTED.
class Call {
 public:
  using Clock = std::chrono::steady_clock;
  virtual ~Call() = default;

  const std::string& method() const noexcept { return method_; }  // "/package.Service/Method"
  const std::string& peer() const noexcept { return peer_; }      // "ipv4:127.0.0.1:52844"
  // The W3C trace context that the client sent; "" = none, or an invalid one. The response carries
  // it too.
  const std::string& trace_parent() const noexcept { return trace_parent_; }
  // When the response becomes useless to the client; max() = never.
  Clock::time_point deadline() const noexcept { return deadline_; }
  // The request. Valid until the last reference goes.
  const Chunks& request() const noexcept { return request_; }
  // Whether the client gave up, or is gone.
  virtual bool cancelled() const noexcept = 0;
  bool expired() const noexcept { return cancelled() || Clock::now() >= deadline_; }

  // Both return false, and do nothing, when the call has ended before. `memory` keeps the memory
  // that the pieces borrow; it may be needed after the call has ended.
  virtual bool respond(const Pieces& pieces, const std::shared_ptr<const void>& memory) = 0;
  virtual bool fail(CallStatus status, const std::string& message) = 0;
  // Whether the call has ended: answered, failed, or as a stream cancelled.
  virtual bool ended() const noexcept = 0;
  // Sends a message of a stream, in the place of one that was not sent yet. False after the end.
  // respond() to a message of a stream, on the thread of the handler, ends the message alone.
  virtual bool send(const Pieces& pieces) = 0;

 protected:
  std::string method_, peer_, trace_parent_;
  Clock::time_point deadline_ = Clock::time_point::max();
  Chunks request_;
  std::shared_ptr<const void> memory_;  // of request_
};

}  // namespace weir::net
