// One thread accepts readers and handles their messages; frames are sent by the caller's thread.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/local/publisher.hpp"

#include <poll.h>
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

Publisher::Publisher(PublisherOptions options)
    : options_(std::move(options)), arena_(isolate::SharedArena::make(kFrameAlignmentPadding)) {}

Result<std::unique_ptr<Publisher>> Publisher::open(PublisherOptions options) {
  auto listener = Listener::open(options.path);
  if (!listener) return listener.error();
  std::unique_ptr<Publisher> out(new Publisher(std::move(options)));
  out->listener_ = *std::move(listener);
  out->thread_ = std::thread([publisher = out.get()] { publisher->serve(); });
  return out;
}

Publisher::~Publisher() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.set();
  if (thread_.joinable()) thread_.join();
}

Publisher::Readers Publisher::active() const {
  Readers out;
  for (const auto& reader : readers_)
    if (reader->state() == ReaderLink::State::Reading) out.push_back(reader);
  return out;
}

Publisher::Outcome Publisher::deliver(Lock* lock, const std::shared_ptr<ReaderLink>& reader,
                                      const Delivery& delivery) {
  const auto reads = [&] { return reader->state() == ReaderLink::State::Reading; };
  const auto has_room = [&] { return reader->has_room(delivery.most_held); };
  while (reads()) {
    if (delivery.may_drop && !has_room()) {
      ++missed_;
      return Outcome::Missed;
    }
    changed_.wait(*lock, [&] { return interrupted_ || !reads() || has_room(); });
    if (interrupted_) return Outcome::Interrupted;
    if (!reads()) break;
    if (delivery.send(*reader)) return Outcome::Sent;
    wake_.set();  // to wait for room in the socket, or to remove the reader
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
  if (text.size() > kMostCapsBytes)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "the caps are too long for a local stream",
                 .offered = std::to_string(text.size()) + " bytes",
                 .needed = "at most " + std::to_string(kMostCapsBytes)};
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
                                options_.most_held, options_.drop});
}

Publisher::Outcome Publisher::end() {
  Lock lock(mutex_);
  ended_ = true;
  return deliver_to_all(&lock, {[](ReaderLink& reader) { return reader.send_end(); }});
}

bool Publisher::wait_for_reader(const io::Deadline& deadline) {
  Lock lock(mutex_);
  const auto ready = [this] { return interrupted_ || !active().empty(); };
  if (!deadline)
    changed_.wait(lock, ready);
  else
    changed_.wait_until(lock, *deadline, ready);
  return !interrupted_ && !active().empty();
}

Publisher::Release Publisher::wait_for_release() {
  Lock lock(mutex_);
  const auto holds = [](const auto& reader) { return reader->holds(); };
  if (interrupted_) return Release::Interrupted;
  if (std::none_of(readers_.begin(), readers_.end(), holds)) return Release::NoneHeld;
  changed_.wait(lock);
  return interrupted_ ? Release::Interrupted : Release::Released;
}

void Publisher::interrupt() {
  const std::lock_guard lock(mutex_);
  interrupted_ = true;
  changed_.notify_all();
}

void Publisher::resume() {
  const std::lock_guard lock(mutex_);
  interrupted_ = false;
}

PublisherCounts Publisher::counts() const {
  const std::lock_guard lock(mutex_);
  return {static_cast<uint32_t>(active().size()), refused_, missed_};
}

void Publisher::greet_new(std::vector<Error>* refusals) {
  while (Descriptor socket = listener_.accept()) {
    const auto user = user_of_peer(socket.get());
    if (user != geteuid()) {
      ++refused_;
      refusals->push_back(refusal(options_.path, "user " + (user ? std::to_string(*user) : "?")));
    } else if (readers_.size() >= options_.most_readers) {
      ++refused_;
      refusals->push_back(refusal(
          options_.path, std::to_string(options_.most_readers) + " readers are already connected"));
    } else {
      readers_.push_back(std::make_shared<ReaderLink>(std::move(socket)));
    }
  }
}

void Publisher::read(const std::shared_ptr<ReaderLink>& reader, std::span<std::byte> buffer,
                     Garbage* garbage, std::vector<Error>* refusals) {
  Packet packet;
  while (reader->state() != ReaderLink::State::Gone) {
    const Transfer transfer = receive_packet(reader->socket(), buffer, &packet);
    if (transfer == Transfer::WouldWait) return;
    if (transfer == Transfer::Closed) return reader->set_gone();
    const bool greeted = reader->state() == ReaderLink::State::Greeting;
    if (const auto reason = reader->handle(packet, garbage)) {
      ++refused_;
      refusals->push_back(refusal(options_.path, *reason));
      return reader->set_gone();
    }
    if (!greeted) continue;
    // The socket is empty: a greeting that does not fit is a reader that is gone.
    const bool sent = reader->welcome(options_.most_held) && reader->send_caps(caps_) &&
                      (!ended_ || reader->send_end());
    if (!sent) return reader->set_gone();
  }
}

void Publisher::refuse_silent(ReaderLink* reader, std::vector<Error>* refusals) {
  if (reader->state() != ReaderLink::State::Greeting || !io::is_over(reader->greeting_ends()))
    return;
  ++refused_;
  refusals->push_back(refusal(options_.path, "it did not start the handshake within 2 s"));
  reader->set_gone();
}

void Publisher::remove_gone(Garbage* garbage) {
  for (const auto& reader : readers_)
    if (reader->state() == ReaderLink::State::Gone) reader->release_all(garbage);
  std::erase_if(readers_, [](auto& r) { return r->state() == ReaderLink::State::Gone; });
}

bool Publisher::serve_once(std::vector<std::byte>* buffer) {
  Readers readers;
  std::vector<pollfd> watched{{wake_.descriptor(), POLLIN, 0}, {listener_.get(), POLLIN, 0}};
  io::Deadline next;
  {
    const std::lock_guard lock(mutex_);
    if (stopping_) return false;
    readers = readers_;
    for (const auto& reader : readers) {
      watched.push_back(
          {reader->socket(), static_cast<short>(reader->is_full() ? POLLIN | POLLOUT : POLLIN), 0});
      if (reader->state() == ReaderLink::State::Greeting)
        next = io::earlier(next, reader->greeting_ends());
    }
  }
  poll(watched.data(), watched.size(), io::poll_timeout(next));
  wake_.clear();
  Garbage garbage;
  std::vector<Error> refusals;
  {
    const std::lock_guard lock(mutex_);
    if (watched[1].revents) greet_new(&refusals);
    for (size_t i = 0; i < readers.size(); ++i) {
      if (watched[i + 2].revents & POLLOUT) readers[i]->set_room();
      if (watched[i + 2].revents & ~POLLOUT) read(readers[i], *buffer, &garbage, &refusals);
      refuse_silent(readers[i].get(), &refusals);
    }
    remove_gone(&garbage);
    changed_.notify_all();
  }
  if (options_.refused)
    for (const Error& error : refusals) options_.refused(error);
  return true;
}

void Publisher::serve() noexcept {
  try {
    std::vector<std::byte> buffer(kMostMessageBytes);
    while (serve_once(&buffer)) {
    }
  } catch (const std::exception& e) {  // the thread entry: memory ran out
    const std::lock_guard lock(mutex_);
    for (const auto& reader : readers_) reader->set_gone();
    changed_.notify_all();
  }
}

}  // namespace weir::local
