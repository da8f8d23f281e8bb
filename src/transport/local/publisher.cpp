// One thread accepts readers and handles their messages; frames are sent by the caller's thread.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/local/publisher.hpp"

#include <unistd.h>

#include <algorithm>
#include <utility>

namespace weir::local {
namespace {

constexpr size_t kFrameAlignmentPadding = 64;  // vector code may read beyond the last tensor

Error refusal(const std::string& path, std::string reason) {
  return Error{.code = Code::PEER_MESSAGE_INVALID,
               .what = "a reader of a local stream was refused",
               .offered = "path=" + path + ": " + std::move(reason),
               .needed = "an edgesrc of the same user and version"};
}

}  // namespace

Publisher::Publisher(LocalPublisherOptions options)
    : PollServer(options.refused),
      options_(std::move(options)),
      arena_(isolate::SharedArena::make(kFrameAlignmentPadding)) {}

Result<std::unique_ptr<Publisher>> Publisher::open(LocalPublisherOptions options) {
  auto listener = Listener::open(options.path);
  if (!listener) return listener.error();
  std::unique_ptr<Publisher> out(new Publisher(std::move(options)));
  out->listener_ = *std::move(listener);
  out->start();
  return out;
}

Publisher::~Publisher() {
  join();
}

Publisher::Clients Publisher::active() const {
  Clients out;
  for (const auto& reader : clients_)
    if (reader->state() == ReaderLink::State::Reading) out.push_back(reader);
  return out;
}

Publisher::Outcome Publisher::deliver(Lock* lock, const Client& reader, const Delivery& delivery) {
  const auto reads = [&] { return reader->state() == ReaderLink::State::Reading; };
  const auto has_room = [&] { return reader->has_room(delivery.max_held); };
  while (reads()) {
    if (delivery.may_drop && !has_room()) {
      ++missed_;
      return Outcome::Missed;
    }
    changed_.wait(*lock, [&] { return interrupted_ || !reads() || has_room(); });
    if (interrupted_) return Outcome::Interrupted;
    if (!reads()) break;
    if (delivery.send(*reader)) return Outcome::Sent;
    wake_->set();  // to wait for room in the socket, or to remove the reader
  }
  return Outcome::NoReader;
}

Publisher::Outcome Publisher::deliver_to_all(Lock* lock, const Delivery& delivery) {
  if (interrupted_) return Outcome::Interrupted;
  Outcome best = Outcome::NoReader;
  for (const auto& reader : active()) {
    const Outcome outcome = deliver(lock, reader, delivery);
    if (outcome == Outcome::Interrupted) return outcome;
    if (outcome == Outcome::Sent || best == Outcome::NoReader) best = outcome;
  }
  return best;
}

Status Publisher::set_caps(std::string text) {
  if (text.size() > kMaxCapsBytes)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "the caps are too long for a local stream",
                 .offered = std::to_string(text.size()) + " bytes",
                 .needed = "at most " + std::to_string(kMaxCapsBytes)};
  Lock lock(mutex_);
  ended_ = false;
  caps_ = std::make_shared<const std::string>(std::move(text));
  deliver_to_all(&lock, {[this](ReaderLink& reader) { return reader.send_caps(caps_); }});
  return ok();
}

Publisher::Outcome Publisher::publish(LocalFrame* frame) {
  Lock lock(mutex_);
  ended_ = false;
  if (frame->number == 0) frame->number = ++last_number_;
  return deliver_to_all(&lock, {[this, frame](ReaderLink& reader) {
                                  return reader.send_caps(caps_) && reader.send_frame(*frame);
                                },
                                options_.max_held, options_.drop});
}

Publisher::Outcome Publisher::end() {
  Lock lock(mutex_);
  ended_ = true;
  return deliver_to_all(&lock, {[](ReaderLink& reader) { return reader.send_end(); }});
}

bool Publisher::wait_for_reader(const io::Deadline& deadline) {
  Lock lock(mutex_);
  return wait(&lock, deadline, [this] { return !active().empty(); });
}

uint64_t Publisher::releases() const {
  const std::lock_guard lock(mutex_);
  return releases_;
}

Publisher::Release Publisher::wait_for_release(uint64_t releases) {
  Lock lock(mutex_);
  const auto none_held = [this] {
    return !has_garbage_ && std::none_of(clients_.begin(), clients_.end(),
                                         [](const auto& reader) { return reader->holds(); });
  };
  const auto released = [&] { return releases_ != releases; };
  changed_.wait(lock, [&] { return interrupted_ || released() || none_held(); });
  if (interrupted_) return Release::Interrupted;
  return released() ? Release::Released : Release::NoneHeld;
}

LocalPublisherCounts Publisher::counts() const {
  const std::lock_guard lock(mutex_);
  return {static_cast<uint32_t>(active().size()), refused_count_, missed_};
}

void Publisher::add(Descriptor socket) {
  const auto user = user_of_peer(socket.get());
  if (user != geteuid())
    refuse(nullptr, refusal(options_.path, "user " + (user ? std::to_string(*user) : "?")));
  else if (clients_.size() >= options_.max_readers)
    refuse(nullptr, refusal(options_.path, std::to_string(options_.max_readers) +
                                               " readers are already connected"));
  else
    clients_.push_back(std::make_shared<ReaderLink>(std::move(socket)));
}

io::Deadline Publisher::watch(const Clients& readers, std::vector<pollfd>* watched) {
  io::Deadline next;
  for (const auto& reader : readers) {
    const auto events = static_cast<short>(reader->is_full() ? POLLIN | POLLOUT : POLLIN);
    watched->push_back({reader->socket(), events, 0});
    if (reader->state() == ReaderLink::State::Greeting)
      next = io::earlier(next, reader->greeting_ends());
  }
  return next;
}

void Publisher::attend(const Client& reader, const pollfd* events, ReaderLink::Input input) {
  if (events->revents & POLLOUT) reader->set_room();
  for (const auto& message : input.messages) {
    const bool greeted = reader->state() == ReaderLink::State::Greeting;
    if (const auto reason = reader->handle(message, &garbage_))
      return refuse(reader.get(), refusal(options_.path, *reason));
    if (!greeted) continue;
    // The socket is empty: a greeting that does not fit is a reader that is gone.
    const bool sent = reader->welcome(options_.max_held) && reader->send_caps(caps_) &&
                      (!ended_ || reader->send_end());
    if (!sent) return reader->set_gone();
  }
  if (input.is_closed) return reader->set_gone();
  if (reader->state() == ReaderLink::State::Greeting && io::is_over(reader->greeting_ends()))
    refuse(reader.get(), refusal(options_.path, "it did not start the handshake within 2 s"));
}

void Publisher::end_turn() {
  for (const auto& reader : clients_)
    if (reader->is_gone()) reader->release_all(&garbage_);
  has_garbage_ = !garbage_.empty();
}

// Memory is free after this, not when a reader said so.
void Publisher::release() {
  if (garbage_.empty()) return;
  garbage_.clear();
  const std::lock_guard lock(mutex_);
  ++releases_;
  has_garbage_ = false;
  changed_.notify_all();
}

}  // namespace weir::local
