// OutgoingFrames: a frame goes to every peer that is connected, through a bounded queue for each.
// Knows no gRPC.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "weir/result.hpp"

namespace weir::net {

// Several streams may send it at a time. `memory` keeps the bytes.
struct OutgoingMessage {
  std::span<const std::byte> bytes;
  std::shared_ptr<const void> memory;
};

// A call to one peer. Both functions start the work and return; they must not call OutgoingFrames.
class OutgoingStream {
 public:
  // Writes at most one message at a time: OutgoingFrames::written() reports its end.
  virtual void write(const OutgoingMessage& message) = 0;
  // Ends the stream after the last message.
  virtual void end() = 0;

 protected:
  ~OutgoingStream() = default;
};

struct OutgoingCounts {
  uint64_t sent = 0;     // messages that were written, once for each peer
  uint64_t dropped = 0;  // because the queue of a peer was full
  uint64_t lost = 0;     // with the connection
  uint64_t peers = 0;    // connected now
};

// Thread-safe.
class OutgoingFrames {
 public:
  struct Options {
    uint32_t queue = 16;  // messages that wait for each peer
    bool waits = true;    // send() waits for a peer that has room; else it drops the message
    bool keeps = false;   // there is one peer, whose messages wait while it is not connected
  };
  enum class Outcome { Queued, Dropped, Interrupted, Failed };

  explicit OutgoingFrames(const Options& options);

  // ---- the element ----
  // Queues the message for each peer that has room. When none has: waits for one, or drops.
  Outcome send(const OutgoingMessage& message);
  // Returns the error after Outcome::Failed.
  std::optional<Error> error() const;
  // Sends what is queued and ends the streams. False when that took longer, or was interrupted.
  bool finish(std::chrono::milliseconds max_wait);
  // Asks for streams again after finish().
  void restart();
  void interrupt();  // send() and finish() return until resume()
  void resume();
  OutgoingCounts counts() const;

  // ---- the connections ----
  // Returns false when no more frames come: the stream must be ended.
  bool join(OutgoingStream* stream);
  // The last write of the stream is done, and its next one may be started here. False when the
  // stream has left.
  bool written(OutgoingStream* stream);
  // No function of the stream is called from here on. True when a write is in progress.
  bool leave(OutgoingStream* stream);
  // Ends the sending: send() returns Failed.
  void fail(Error error);
  // Waits until a stream would have anything to send. False after fail() or close().
  bool wait_until_needed();
  void close();

 private:
  struct Peer {
    OutgoingStream* stream = nullptr;
    std::deque<OutgoingMessage> queue;
    bool writing = false, ended = false;
  };
  Peer* find(const OutgoingStream* stream);
  bool queue_for_all(const OutgoingMessage& message);
  void go_on(Peer* peer);
  bool is_done() const;
  bool accepts() const;

  const Options options_;
  mutable std::mutex mutex_;  // guards the rest
  std::condition_variable changed_;
  std::vector<std::unique_ptr<Peer>> peers_;
  bool interrupted_ = false, finishing_ = false, closed_ = false;
  std::optional<Error> error_;
  OutgoingCounts counts_;
};

}  // namespace weir::net
