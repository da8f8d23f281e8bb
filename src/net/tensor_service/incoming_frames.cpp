// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/tensor_service/incoming_frames.hpp"

#include <algorithm>

namespace weir::net {

IncomingMessage IncomingFrames::pop() {
  IncomingMessage out = std::move(queue_.front());
  queue_.pop_front();
  bytes_ -= out.chunks.size();
  return out;
}

// Starts the reads that waited for room.
void IncomingFrames::read_on() {
  for (auto& peer : peers_) {
    if (options_.waits && is_full()) return;
    if (!peer.waits) continue;
    peer.waits = false;
    peer.stream->read();
  }
}

IncomingFrames::Taken IncomingFrames::take() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return interrupted_ || !queue_.empty() || ended_ || error_; });
  if (interrupted_) return {};
  if (!queue_.empty()) {
    Taken out{Outcome::Message, pop(), {}};
    read_on();
    return out;
  }
  if (error_) return {Outcome::Failed, {}, error_};
  return {Outcome::Ended, {}, {}};
}

void IncomingFrames::refuse(const IncomingMessage& message, const std::string& why) {
  std::lock_guard lock(mutex_);
  ++counts_.refused;
  std::erase_if(queue_, [&](const IncomingMessage& other) {
    if (other.stream != message.stream) return false;
    ++counts_.refused;
    bytes_ -= other.chunks.size();
    return true;
  });
  std::erase_if(peers_, [&](const Peer& peer) {
    if (peer.number != message.stream) return false;
    peer.stream->refuse(CallStatus::InvalidArgument, why);
    return true;
  });
  read_on();
}

void IncomingFrames::interrupt() {
  std::lock_guard lock(mutex_);
  interrupted_ = true;
  changed_.notify_all();
}

void IncomingFrames::resume() {
  std::lock_guard lock(mutex_);
  interrupted_ = false;
}

void IncomingFrames::close() {
  std::lock_guard lock(mutex_);
  closed_ = true;
  for (const auto& peer : peers_)
    peer.stream->refuse(CallStatus::Unavailable, "the stream of the receiver has ended");
  peers_.clear();
}

IncomingCounts IncomingFrames::counts() const {
  std::lock_guard lock(mutex_);
  auto out = counts_;
  out.peers = peers_.size();
  return out;
}

bool IncomingFrames::join(IncomingStream* stream) {
  std::lock_guard lock(mutex_);
  if (closed_) return false;
  peers_.push_back({stream, ++streams_, true});
  read_on();
  return true;
}

void IncomingFrames::arrived(IncomingStream* stream, IncomingMessage message) {
  std::lock_guard lock(mutex_);
  const auto peer = std::find_if(peers_.begin(), peers_.end(),
                                 [&](const Peer& one) { return one.stream == stream; });
  if (peer == peers_.end()) return;
  ++counts_.received;
  message.stream = peer->number;
  bytes_ += message.chunks.size();
  queue_.push_back(std::move(message));
  while (!options_.waits && queue_.size() > 1 &&
         (queue_.size() > options_.queue || bytes_ > options_.max_bytes)) {
    pop();
    ++counts_.dropped;
  }
  peer->waits = true;
  std::rotate(peer, peer + 1, peers_.end());
  read_on();
  changed_.notify_all();
}

bool IncomingFrames::leave(IncomingStream* stream) {
  std::lock_guard lock(mutex_);
  return std::erase_if(peers_, [&](const Peer& peer) { return peer.stream == stream; }) > 0;
}

void IncomingFrames::end() {
  std::lock_guard lock(mutex_);
  ended_ = true;
  changed_.notify_all();
}

void IncomingFrames::fail(Error error) {
  std::lock_guard lock(mutex_);
  if (!error_) error_ = std::move(error);
  changed_.notify_all();
}

}  // namespace weir::net
