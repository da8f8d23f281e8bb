// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/tensor_service/outgoing_frames.hpp"

#include <algorithm>

namespace weir::net {

OutgoingFrames::OutgoingFrames(const Options& options) : options_(options) {
  if (options_.keeps) peers_.push_back(std::make_unique<Peer>());
}

OutgoingFrames::Outcome OutgoingFrames::send(const OutgoingMessage& message) {
  std::unique_lock lock(mutex_);
  for (;;) {
    if (error_) return Outcome::Failed;
    if (interrupted_) return Outcome::Interrupted;
    if (queue_for_all(message)) return Outcome::Queued;
    if (!options_.waits) return Outcome::Dropped;
    changed_.wait(lock);
  }
}

// A peer without room misses the message when another one has room: a client that does not read
// must not stop the others.
bool OutgoingFrames::queue_for_all(const OutgoingMessage& message) {
  const auto has_room = [this](const auto& peer) {
    return !peer->ended && peer->queue.size() < options_.queue;
  };
  if (options_.waits && std::none_of(peers_.begin(), peers_.end(), has_room)) return false;
  bool queued = false;
  for (const auto& peer : peers_) {
    if (!has_room(peer)) {
      ++counts_.dropped;
      continue;
    }
    queued = true;
    peer->queue.push_back(message);
    go_on(peer.get());
  }
  return queued;
}

void OutgoingFrames::go_on(Peer* peer) {
  if (!peer->stream || peer->writing || peer->ended) return;
  if (!peer->queue.empty()) {
    peer->writing = true;
    peer->stream->write(peer->queue.front());
    peer->queue.pop_front();
  } else if (finishing_) {
    peer->ended = true;
    peer->stream->end();
  }
}

std::optional<Error> OutgoingFrames::error() const {
  std::lock_guard lock(mutex_);
  return error_;
}

bool OutgoingFrames::is_done() const {
  return std::all_of(peers_.begin(), peers_.end(),
                     [](const auto& peer) { return !peer->stream && peer->queue.empty(); });
}

bool OutgoingFrames::finish(std::chrono::milliseconds max_wait) {
  std::unique_lock lock(mutex_);
  finishing_ = true;
  for (const auto& peer : peers_) go_on(peer.get());
  changed_.notify_all();
  changed_.wait_for(lock, max_wait, [this] { return is_done() || interrupted_ || error_; });
  return is_done();
}

void OutgoingFrames::restart() {
  std::lock_guard lock(mutex_);
  finishing_ = false;
  changed_.notify_all();
}

void OutgoingFrames::interrupt() {
  std::lock_guard lock(mutex_);
  interrupted_ = true;
  changed_.notify_all();
}

void OutgoingFrames::resume() {
  std::lock_guard lock(mutex_);
  interrupted_ = false;
}

OutgoingCounts OutgoingFrames::counts() const {
  std::lock_guard lock(mutex_);
  auto out = counts_;
  for (const auto& peer : peers_) out.peers += peer->stream ? 1 : 0;
  return out;
}

OutgoingFrames::Peer* OutgoingFrames::find(const OutgoingStream* stream) {
  for (const auto& peer : peers_)
    if (peer->stream == stream) return peer.get();
  return nullptr;
}

bool OutgoingFrames::accepts() const {
  const bool has_rest = options_.keeps && !peers_[0]->queue.empty();
  return !error_ && (!finishing_ || has_rest);
}

bool OutgoingFrames::join(OutgoingStream* stream) {
  std::lock_guard lock(mutex_);
  if (!accepts()) return false;
  if (!options_.keeps) peers_.push_back(std::make_unique<Peer>());
  Peer* peer = peers_.back().get();
  peer->stream = stream;
  peer->writing = peer->ended = false;
  go_on(peer);
  changed_.notify_all();
  return true;
}

bool OutgoingFrames::written(OutgoingStream* stream) {
  std::lock_guard lock(mutex_);
  Peer* peer = find(stream);
  if (!peer) return false;
  ++counts_.sent;
  peer->writing = false;
  go_on(peer);
  changed_.notify_all();
  return true;
}

bool OutgoingFrames::leave(OutgoingStream* stream) {
  std::lock_guard lock(mutex_);
  Peer* peer = find(stream);
  if (!peer) return false;
  const bool writing = peer->writing;
  counts_.lost += writing ? 1 : 0;
  peer->stream = nullptr;
  peer->writing = peer->ended = false;
  if (!options_.keeps) {
    counts_.lost += peer->queue.size();
    std::erase_if(peers_, [&](const auto& one) { return one.get() == peer; });
  }
  changed_.notify_all();
  return writing;
}

void OutgoingFrames::fail(Error error) {
  std::lock_guard lock(mutex_);
  if (!error_) error_ = std::move(error);
  changed_.notify_all();
}

bool OutgoingFrames::wait_until_needed() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return closed_ || error_ || accepts(); });
  return !closed_ && !error_;
}

void OutgoingFrames::close() {
  std::lock_guard lock(mutex_);
  closed_ = true;
  changed_.notify_all();
}

}  // namespace weir::net
