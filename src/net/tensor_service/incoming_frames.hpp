// IncomingFrames: the messages of all peers that send, in one bounded queue. Knows no gRPC.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "net/protocol/outcome.hpp"
#include "net/protocol/wire.hpp"
#include "weir/result.hpp"

namespace weir::net {

// A message in the memory in which it arrived.
struct IncomingMessage {
  Chunks chunks;
  std::shared_ptr<const void> memory;  // of the chunks
  std::string peer;                    // "ipv4:127.0.0.1:52844"
  uint64_t stream = 0;                 // which stream it came by
};

// A call from one peer. Both functions start the work and return; they must not call
// IncomingFrames.
class IncomingStream {
 public:
  // Reads a message, at most one at a time: IncomingFrames::arrived() brings it.
  virtual void read() = 0;
  // Ends the call with an error; no function is called after it.
  virtual void refuse(CallStatus status, const std::string& why) = 0;

 protected:
  ~IncomingStream() = default;
};

struct IncomingCounts {
  uint64_t received = 0;  // messages
  uint64_t dropped = 0;   // because the queue was full
  uint64_t refused = 0;   // because they cannot be used
  uint64_t peers = 0;     // connected now
};

// Thread-safe.
class IncomingFrames {
 public:
  struct Options {
    uint32_t queue = 16;                   // messages that wait for the element
    size_t max_bytes = size_t{256} << 20;  // of them
    bool waits = true;  // peers wait while the queue is full; else the oldest message is dropped
  };
  enum class Outcome { Message, Interrupted, Ended, Failed };
  struct Taken {
    Outcome outcome = Outcome::Interrupted;
    IncomingMessage message;
    std::optional<Error> error;
  };

  explicit IncomingFrames(const Options& options) : options_(options) {}

  // ---- the element ----
  // Waits for a message.
  Taken take();
  // The message cannot be used: ends its stream and drops what else came by it.
  void refuse(const IncomingMessage& message, const std::string& why);
  void interrupt();  // take() returns until resume()
  void resume();
  // Ends all streams: UNAVAILABLE.
  void close();
  IncomingCounts counts() const;

  // ---- the connections ----
  // Starts the first read. False after close().
  bool join(IncomingStream* stream);
  // The read of the stream brought this message; the next read is started here or later.
  void arrived(IncomingStream* stream, IncomingMessage message);
  // No function of the stream is called from here on. False when it has left before.
  bool leave(IncomingStream* stream);
  void end();              // take() returns Ended after the last message
  void fail(Error error);  // take() returns Failed after the last message

 private:
  struct Peer {
    IncomingStream* stream = nullptr;
    uint64_t number = 0;
    bool waits = false;  // its next read was not started
  };
  bool is_full() const { return queue_.size() >= options_.queue || bytes_ >= options_.max_bytes; }
  IncomingMessage pop();
  void read_on();

  const Options options_;
  mutable std::mutex mutex_;  // guards the rest
  std::condition_variable changed_;
  std::vector<Peer> peers_;  // the one that waits longest comes first
  std::deque<IncomingMessage> queue_;
  size_t bytes_ = 0;
  uint64_t streams_ = 0;
  bool interrupted_ = false, ended_ = false, closed_ = false;
  std::optional<Error> error_;
  IncomingCounts counts_;
};

}  // namespace weir::net
