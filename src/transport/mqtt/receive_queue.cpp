// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/mqtt/receive_queue.hpp"

namespace weir::transport {

void ReceiveQueue::push(MqttMessage message) {
  {
    std::lock_guard lock(mutex_);
    const size_t size = message.payload.size();
    while (!messages_.empty() &&
           (messages_.size() >= max_messages_ || bytes_ + size > max_bytes_)) {
      bytes_ -= messages_.front().payload.size();
      messages_.pop_front();
      ++dropped_;
    }
    if (size > max_bytes_) {
      ++dropped_;
      return;
    }
    bytes_ += size;
    messages_.push_back(std::move(message));
  }
  arrived_.notify_one();
}

std::optional<MqttMessage> ReceiveQueue::pop(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  arrived_.wait_for(lock, timeout, [this] { return interrupted_ || !messages_.empty(); });
  if (interrupted_ || messages_.empty()) return std::nullopt;
  MqttMessage out = std::move(messages_.front());
  messages_.pop_front();
  bytes_ -= out.payload.size();
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
