// The bounded queue of messages that a broker delivered.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>

#include "transport/mqtt/mqtt_message.hpp"

namespace weir::transport {

// Thread-safe.
class ReceiveQueue {
 public:
  ReceiveQueue(size_t max_messages, size_t max_bytes)
      : max_messages_(max_messages), max_bytes_(max_bytes) {}

  // Drops the oldest messages where the new one would exceed the limits, and only the new one if it
  // exceeds them alone. Counts what it drops.
  void push(MqttMessage message);
  // Waits for a message. Nullopt after the time, and after interrupt().
  std::optional<MqttMessage> pop(std::chrono::milliseconds timeout);
  // Ends a pop() that waits, and all until set_interrupted(false).
  void set_interrupted(bool interrupted);
  // Whether half of a limit is used.
  bool is_half_full() const;
  // Messages dropped so far.
  uint64_t dropped() const;

 private:
  const size_t max_messages_, max_bytes_;
  mutable std::mutex mutex_;  // guards the members below
  std::condition_variable arrived_;
  std::deque<MqttMessage> messages_;
  size_t bytes_ = 0;
  uint64_t dropped_ = 0;
  bool interrupted_ = false;
};

}  // namespace weir::transport
