// Reads into the message and beyond it at once.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/edge/message_connection.hpp"

#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <cerrno>
#include <span>

namespace weir::edge {

Status MessageConnection::use_ahead() {
  const auto taken = reader_.feed(std::span(ahead_).subspan(begin_, end_ - begin_));
  if (!taken) return taken.error();
  begin_ += *taken;
  return ok();
}

Result<std::optional<MessageConnection::Read>> MessageConnection::receive() {
  const auto room = reader_.space();
  iovec parts[] = {{room.data(), room.size()}, {ahead_.data(), ahead_.size()}};
  msghdr head{};
  head.msg_iov = parts;
  head.msg_iovlen = 2;
  ssize_t got = -1;
  do {
    got = recvmsg(socket_.get(), &head, MSG_DONTWAIT);
  } while (got < 0 && errno == EINTR);
  if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return std::optional(Read::Nothing);
  if (got <= 0) return std::optional(Read::Closed);
  bytes_received_ += static_cast<uint64_t>(got);
  const size_t used = std::min(static_cast<size_t>(got), room.size());
  begin_ = 0;
  end_ = static_cast<size_t>(got) - used;
  if (auto status = reader_.received(used); !status) return status.error();
  return std::optional<Read>();
}

Result<MessageConnection::Step> MessageConnection::read() {
  for (;;) {
    if (has_read_ahead())
      if (auto status = use_ahead(); !status) return status.error();
    if (reader_.complete()) break;
    const auto ended = receive();
    if (!ended) return ended.error();
    if (*ended) return Step{**ended};
  }
  Step out{Read::Message, wire::Action::Ignore, reader_.take()};
  const auto action = conversation_.next(out.message.command);
  if (!action) return action.error();
  out.action = *action;
  return out;
}

}  // namespace weir::edge
