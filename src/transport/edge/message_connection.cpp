// Reads into the message and beyond it at once.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/edge/message_connection.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <cerrno>
#include <span>

namespace weir::edge {
namespace {

// A peer that sends nothing for so long waits for this end: it decides the form of some greetings.
constexpr auto kSilence = std::chrono::milliseconds(200);

}  // namespace

Status MessageConnection::use_ahead() {
  const auto taken = reader_->feed(std::span(ahead_).subspan(begin_, end_ - begin_));
  if (!taken) return taken.error();
  begin_ += *taken;
  return ok();
}

Result<std::optional<MessageConnection::Read>> MessageConnection::receive(size_t* turn) {
  const auto room = reader_->space();
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
  const auto count = static_cast<size_t>(got);
  bytes_received_ += count;
  partial_bytes_ += count;
  *turn -= std::min(*turn, count);
  const size_t used = std::min(count, room.size());
  begin_ = 0;
  end_ = count - used;
  if (auto status = reader_->received(used); !status) return status.error();
  return std::optional<Read>();
}

Result<MessageConnection::Step> MessageConnection::read(size_t* turn) {
  for (;;) {
    if (has_read_ahead())
      if (auto status = use_ahead(); !status) return status.error();
    if (!reader_->complete()) {
      if (*turn == 0) return Step{};
      const auto ended = receive(turn);
      if (!ended) return ended.error();
      if (*ended) return Step{**ended};
      continue;
    }
    Step out{Read::Message, wire::Action::Ignore, reader_->take()};
    partial_bytes_ = end_ - begin_;
    const auto action = conversation_.next(out.message.command);
    if (!action) return action.error();
    out.action = *action;
    if (out.action != wire::Action::Ignore) return out;
  }
}

Result<MessageConnection::Step> MessageConnection::wait(const io::Deadline& deadline, int cancel) {
  for (;;) {
    size_t turn = kTurnBytes;
    auto step = read(&turn);
    if (!step || step->read != Read::Nothing) return step;
    const bool undecided = !reader_->form() && !reader_->at_start();
    const auto until = undecided ? io::deadline_in(kSilence) : deadline;
    pollfd watched[] = {{socket_.get(), POLLIN, 0}, {cancel, POLLIN, 0}};
    const int ready = poll(watched, 2, io::poll_timeout(until));
    if (ready < 0 && errno != EINTR) return Step{Read::Closed};
    if (ready > 0 && watched[1].revents) return Step{Read::Cancelled};
    if (ready == 0 && undecided && io::is_over(until))
      if (auto status = reader_->silence(); !status) return status.error();
    if (io::is_over(deadline)) return Step{Read::Late};
  }
}

}  // namespace weir::edge
