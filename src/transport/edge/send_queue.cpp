// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/edge/send_queue.hpp"

#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace weir::edge {
namespace {

constexpr size_t kMaxParts = 64;  // of one call of sendmsg()

}  // namespace

void SendQueue::add(Queued queued) {
  if (queue_.empty()) waiting_since_ = std::chrono::steady_clock::now();
  queued_bytes_ += queued.bytes;
  queue_.push_back(std::move(queued));
}

void SendQueue::push(std::vector<std::byte> message) {
  const size_t bytes = message.size();
  add({std::move(message), nullptr, bytes});
}

bool SendQueue::push(std::vector<std::byte> header, std::shared_ptr<const SharedMessage> message,
                     const QueueLimits& limits) {
  const uint64_t bytes = message->bytes;
  const bool fits =
      queue_.size() < limits.frames && (queue_.empty() || queued_bytes_ + bytes <= limits.bytes);
  if (!fits) {
    if (!full_since_) full_since_ = std::chrono::steady_clock::now();
    return false;
  }
  full_since_ = std::nullopt;
  add({std::move(header), std::move(message), bytes});
  return true;
}

void SendQueue::drop_sent(size_t count) {
  waiting_since_ = std::chrono::steady_clock::now();
  sent_ += count;
  while (!queue_.empty() && sent_ >= queue_.front().bytes) {
    sent_ -= queue_.front().bytes;
    queued_bytes_ -= queue_.front().bytes;
    queue_.pop_front();
    full_since_ = std::nullopt;
  }
  if (queue_.empty()) waiting_since_ = std::nullopt;
}

bool SendQueue::send(int socket) {
  while (!queue_.empty()) {
    iovec parts[kMaxParts];
    size_t used = 0, skip = sent_;
    const auto add = [&](std::span<const std::byte> bytes) {
      const size_t skipped = std::min(skip, bytes.size());
      skip -= skipped;
      if (skipped < bytes.size() && used < kMaxParts)
        parts[used++] = {const_cast<std::byte*>(bytes.data()) + skipped, bytes.size() - skipped};
    };
    add(queue_.front().header);
    if (const auto& message = queue_.front().message)
      for (const auto& memory : message->memories) add(memory);
    msghdr head{};
    head.msg_iov = parts;
    head.msg_iovlen = used;
    const ssize_t sent = sendmsg(socket, &head, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent >= 0) {
      drop_sent(static_cast<size_t>(sent));
      continue;
    }
    if (errno == EINTR) continue;
    return errno == EAGAIN || errno == EWOULDBLOCK;
  }
  return true;
}

}  // namespace weir::edge
