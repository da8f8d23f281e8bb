// ServedClient: one query client as its server sees it (docs/compatibility/edge-wire.md 10.1).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/wire/edge_conversation.hpp"
#include "core/wire/message_reader.hpp"
#include "transport/edge/received_request.hpp"
#include "transport/edge/send_queue.hpp"
#include "transport/edge/stream_socket.hpp"

namespace weir::edge {

struct ClientOptions {
  // The form of the headers of clients. Nullopt: a greeting that those of 168 and 2088 bytes
  // understand; they decide.
  std::optional<wire::HeaderForm> form{};
  uint64_t most_message_bytes = uint64_t{64} << 20;
  QueueLimits answers{};
  // How long a client may wait for the greeting, pause within a message, and not read its answers;
  // 0 = no limit.
  std::chrono::milliseconds patience{10000};
  // Whether the answers of a client may go to this other IPv4 address; empty: they may not.
  std::function<bool(const std::string& address)> allows_callback{};
};

// Used under the listener's lock. Nothing here blocks. What is returned as a text is why the client
// is refused.
class ServedClient {
 public:
  using Refusal = std::optional<std::string>;
  enum class State {
    Waiting,     // for the caps that it is greeted with
    Greeted,     // its HOST_INFO has to come
    Connecting,  // to its own listener, for the answers
    Ready,
    Gone
  };

  // `options` must outlive it. `a`: the connection that the client opened.
  ServedClient(Descriptor a, int64_t id, const ClientOptions& options);

  int64_t id() const noexcept { return id_; }
  const std::string& address() const noexcept { return address_; }
  State state() const noexcept { return state_; }
  const std::shared_ptr<ClientLoad>& load() const noexcept { return load_; }
  void set_gone() noexcept;
  // When it is refused unless it does what is due; nullopt: it need not do anything.
  io::Deadline deadline() const;
  // Why it is refused then.
  std::string reason_of_deadline() const;

  // Announces the caps. Errors: those of wire::text_message().
  Status greet(const std::string& capability);
  int requests_socket() const noexcept { return a_.get(); }
  int answers_socket() const noexcept { return b_.get(); }  // -1: there is none yet
  bool has_unsent_greeting() const noexcept { return !greeting_.empty(); }
  // Whether the second connection waits to be made, or to take answers.
  bool has_unsent_answers() const noexcept {
    return state_ == State::Connecting || !answers_.empty();
  }
  bool has_answers() const noexcept { return !answers_.empty(); }
  // Bytes of the message that arrives.
  uint64_t partial_bytes() const noexcept { return partial_bytes_; }
  void set_reading(bool reading);

  struct Request {
    std::vector<wire::ByteBlock> memories{};
    std::string sequence{};
  };
  // Reads from the first connection; at most one request in each call.
  Refusal receive(std::optional<Request>* request);
  // Goes on with the second connection.
  Refusal attend_answers();
  // Queues an answer. False: the queue is full. Errors: those of wire::write_header().
  Result<bool> queue_answer(const std::vector<std::span<const std::byte>>& memories,
                            std::shared_ptr<const void> owner, const std::string& sequence);
  // Sends what the sockets take.
  void send();
  // Reports to the client that this end closes.
  void send_errors() noexcept;

 private:
  Refusal take_message(std::optional<Request>* request);
  Refusal host_info(const wire::EdgeMessage& message);
  Refusal read_answers_socket();

  const int64_t id_;
  const ClientOptions& options_;
  const Descriptor a_;
  Descriptor b_;
  const std::string address_;
  State state_ = State::Waiting;
  std::chrono::steady_clock::time_point since_ = std::chrono::steady_clock::now();  // of the state
  wire::HeaderForm form_;
  std::unique_ptr<wire::MessageReader> reader_, answers_reader_;
  wire::Conversation conversation_{wire::Side::ServerOnA};
  SendQueue greeting_, answers_;
  uint64_t partial_bytes_ = 0;
  bool reading_ = true;
  std::chrono::steady_clock::time_point last_bytes_ = since_;
  const std::shared_ptr<ClientLoad> load_ = std::make_shared<ClientLoad>();
};

}  // namespace weir::edge
