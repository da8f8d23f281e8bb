// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/mqtt/receive_queue.hpp"

#include "core/io/deadline.hpp"

namespace weir::transport {

void ReceiveQueue::push(MqttMessage message) {
  {
    std::lock_guard lock(mutex_);
    const size_t size = message.bytes();
    if (size > max_bytes_) {
      ++dropped_;
      return;
    }
    while (!messages_.empty() &&
           (messages_.size() >= max_messages_ || bytes_ + size > max_bytes_)) {
      bytes_ -= messages_.front().bytes();
      messages_.pop_front();
      ++dropped_;
    }
    bytes_ += size;
    messages_.push_back(std::move(message));
  }
  arrived_.notify_one();
}

std::optional<MqttMessage> ReceiveQueue::pop(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  const auto ready = [this] { return interrupted_ || !messages_.empty(); };
  if (const auto deadline = io::deadline_in(timeout))
    arrived_.wait_until(lock, *deadline, ready);
  else
    arrived_.wait(lock, ready);
  if (interrupted_ || messages_.empty()) return std::nullopt;
  MqttMessage out = std::move(messages_.front());
  messages_.pop_front();
  bytes_ -= out.bytes();
  return out;
}

void ReceiveQueue::set_interrupted(bool interrupted) {
  {
    std::lock_guard lock(mutex_);
    interrupted_ = interrupted;
  }
  arrived_.notify_all();
}

bool ReceiveQueue::is_half_full() const {
  std::lock_guard lock(mutex_);
  return 2 * messages_.size() >= max_messages_ || bytes_ >= max_bytes_ / 2;
}

uint64_t ReceiveQueue::dropped() const {
  std::lock_guard lock(mutex_);
  return dropped_;
}

}  // namespace weir::transport
