// Messages with non-blocking sendmsg and recvmsg.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/channel.hpp"

#include <poll.h>
#include <sched.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <iterator>

namespace weir::isolate {
namespace {

bool would_wait() {
  return errno == EAGAIN || errno == EWOULDBLOCK;
}

// Yields the CPU between two attempts.
bool may_look_again(std::chrono::steady_clock::time_point until) {
  if (std::chrono::steady_clock::now() >= until) return false;
  sched_yield();
  return true;
}

// Calls poll() with a deadline. Signals do not interrupt it.
int poll_until(std::span<pollfd> watched, const io::Deadline& deadline) {
  for (;;) {
    const int ready = poll(watched.data(), watched.size(), io::poll_timeout(deadline));
    const bool interrupted = ready < 0 && errno == EINTR;
    if (!interrupted && (ready != 0 || io::is_over(deadline))) return ready;
  }
}

// Calls recvmsg(). A descriptor that comes with the bytes goes to `came`.
ssize_t receive_some(int socket, std::span<std::byte> into, io::Descriptor* came) {
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  iovec part{into.data(), into.size()};
  msghdr head{};
  head.msg_iov = &part;
  head.msg_iovlen = 1;
  head.msg_control = control;
  head.msg_controllen = CMSG_LEN(sizeof(int));  // room for one: the kernel closes others
  const ssize_t got = recvmsg(socket, &head, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  if (got <= 0) return got;
  const cmsghdr* const along = CMSG_FIRSTHDR(&head);
  if (along && along->cmsg_level == SOL_SOCKET && along->cmsg_type == SCM_RIGHTS &&
      along->cmsg_len == CMSG_LEN(sizeof(int))) {
    int number = -1;
    std::memcpy(&number, CMSG_DATA(along), sizeof number);
    *came = io::Descriptor(number);
  }
  return got;
}

}  // namespace

Passage Channel::wait(short events, const io::Deadline& deadline) const {
  pollfd watched[] = {
      {socket_.get(), events, 0}, {process_, POLLIN, 0}, {stop_, POLLIN, 0}, {cancel_, POLLIN, 0}};
  const int ready = poll_until(watched, deadline);
  if (ready < 0) return Passage::Ended;
  if (ready == 0) return Passage::TimedOut;
  // Data sent before the process ended is read first.
  if (watched[0].revents & events) return Passage::Done;
  if (watched[0].revents || watched[1].revents) return Passage::Ended;
  return Passage::Cancelled;
}

Passage Channel::send(std::span<const std::byte> message, const io::Deadline& deadline,
                      int descriptor) {
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  while (!message.empty()) {
    iovec part{const_cast<std::byte*>(message.data()), message.size()};
    msghdr head{};
    head.msg_iov = &part;
    head.msg_iovlen = 1;
    if (descriptor >= 0) {
      head.msg_control = control;
      head.msg_controllen = sizeof control;
      cmsghdr* const along = CMSG_FIRSTHDR(&head);
      along->cmsg_level = SOL_SOCKET;
      along->cmsg_type = SCM_RIGHTS;
      along->cmsg_len = CMSG_LEN(sizeof(int));
      std::memcpy(CMSG_DATA(along), &descriptor, sizeof descriptor);
    }
    const ssize_t sent = sendmsg(socket_.get(), &head, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0 && !would_wait()) return Passage::Ended;
    if (sent < 0) {
      if (const auto passage = wait(POLLOUT, deadline); passage != Passage::Done) return passage;
      continue;
    }
    message = message.subspan(static_cast<size_t>(sent));
    descriptor = -1;
  }
  return Passage::Done;
}

Passage Channel::receive_bytes(std::span<std::byte> into, const io::Deadline& deadline,
                               std::chrono::steady_clock::time_point look_until,
                               io::Descriptor* came) {
  while (!into.empty()) {
    const ssize_t got = receive_some(socket_.get(), into, came);
    if (got == 0) return Passage::Ended;
    if (got > 0) {
      into = into.subspan(static_cast<size_t>(got));
      continue;
    }
    if (errno == EINTR) continue;
    if (!would_wait()) return Passage::Ended;
    if (may_look_again(look_until)) continue;
    if (const auto passage = wait(POLLIN, deadline); passage != Passage::Done) return passage;
  }
  return Passage::Done;
}

Passage Channel::receive(const io::Deadline& deadline, Message* out) {
  MessageHead head{};
  out->descriptor = {};
  const auto head_bytes = std::as_writable_bytes(std::span(&head, 1));
  const auto began = std::chrono::steady_clock::now(), look_until = began + usual_.poll_time();
  if (const auto p = receive_bytes(head_bytes, deadline, look_until, &out->descriptor);
      p != Passage::Done)
    return p;
  usual_.took(std::chrono::steady_clock::now() -
              began);  // the body follows immediately after the head
  if (head.bytes > kMaxMessageBytes) return Passage::Unreadable;
  out->kind = static_cast<Kind>(head.kind);
  out->body.resize(head.bytes);
  return receive_bytes(out->body, deadline, look_until, &out->descriptor);
}

}  // namespace weir::isolate
