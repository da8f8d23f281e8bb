// ConnectionCost: what a connection has received that its messages do not explain.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <chrono>
#include <cstdint>

namespace weir::net {

// Bytes, without those of TCP.
struct Traffic {
  uint64_t received = 0, acknowledged = 0;
};

// gRPC keeps what belongs to no message, such as headers that never end, in memory without a limit.
// So a connection may receive a MiB besides its messages, and a little for what it is sent: frames
// that open the window of a response.
//
// Pings would use up the MiB after days. Each is answered with as many bytes, and these count again
// for what was received, up to a rate that is enough for ten pings a second. Headers without an end
// have no answer, and a flood of pings is faster.
class ConnectionCost {
 public:
  using Time = std::chrono::steady_clock::time_point;

  // Starts again: a call began or a message came.
  void restart(const Traffic& traffic, Time now) {
    paid_ = last_ = traffic;
    last_at_ = now;
  }
  // Whether `traffic` is more than what messages of so many bytes explain. Call it regularly.
  bool is_too_high(const Traffic& traffic, uint64_t message_bytes, Time now) {
    constexpr uint64_t kFreeBytes = 1 << 20, kResponsePart = 64;
    paid_.received = std::min(traffic.received, paid_.received + refund(traffic, now));
    last_ = traffic;
    last_at_ = now;
    // With a quarter more for the frames around the messages.
    const uint64_t messages = message_bytes + message_bytes / 4;
    const uint64_t responses = (traffic.acknowledged - paid_.acknowledged) / kResponsePart;
    return traffic.received - paid_.received > kFreeBytes + messages + responses;
  }

 private:
  uint64_t refund(const Traffic& traffic, Time now) const {
    constexpr uint64_t kBytesPerSecond = 512, kMsPerSecond = 1000;
    const auto time = std::chrono::floor<std::chrono::milliseconds>(now - last_at_).count();
    return std::min(traffic.acknowledged - last_.acknowledged,
                    static_cast<uint64_t>(time) * kBytesPerSecond / kMsPerSecond);
  }

  Traffic paid_, last_;  // paid_: does not count any more
  Time last_at_ = std::chrono::steady_clock::now();
};

}  // namespace weir::net
