// StreamSubscriber: the receiving end of a stream in NNStreamer's protocol over TCP
// (docs/compatibility/edge-wire.md 10.1).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/io/deadline.hpp"
#include "core/wire/edge_message_reader.hpp"
#include "transport/edge/message_connection.hpp"

namespace weir::edge {

// Used by one thread.
class StreamSubscriber {
 public:
  // Within `connect` there must be a connection, and a greeting `greet` after it.
  struct Times {
    std::chrono::milliseconds connect{10000}, greet{10000};
  };
  // Connects; greet() is due next. `cancel` is a borrowed descriptor that ends waiting when
  // readable, or -1. SERVER_UNREACHABLE, CANCELLED.
  static Result<StreamSubscriber> open(const std::string& host, uint32_t port,
                                       const wire::MessageLimits& limits,
                                       std::chrono::milliseconds time, int cancel);
  // Answers the greeting, which a publisher sends when it knows its caps. False: it has not come
  // before the deadline, and greet() can be called again. SERVER_UNREACHABLE, SERVER_REFUSED,
  // PEER_MESSAGE_INVALID, CANCELLED (it can be called again).
  Result<bool> greet(const io::Deadline& deadline, int cancel);
  // Connects and answers the greeting. The errors of both, SERVER_REFUSED without a greeting.
  static Result<StreamSubscriber> connect(const std::string& host, uint32_t port,
                                          const wire::MessageLimits& limits, int cancel = -1);
  static Result<StreamSubscriber> connect(const std::string& host, uint32_t port,
                                          const wire::MessageLimits& limits, const Times& times,
                                          int cancel);

  // The caps that the publisher announced; "" if it did not know them.
  const std::string& caps() const noexcept { return caps_; }

  enum class End { Lost, Interrupted };
  struct Received {
    std::vector<wire::ByteBlock> memories{};  // of a frame
    std::optional<End> end{};                 // instead of a frame
  };
  // Waits for the next frame, after greet(). PEER_MESSAGE_INVALID: close the connection.
  Result<Received> receive(int cancel = -1);

 private:
  StreamSubscriber(Descriptor socket, const wire::MessageLimits& limits)
      : connection_(std::make_unique<MessageConnection>(std::move(socket), wire::Side::Subscriber,
                                                        limits)) {}
  Status send_host_info(int64_t client_id);

  std::unique_ptr<MessageConnection> connection_;
  std::string caps_;
};

}  // namespace weir::edge
