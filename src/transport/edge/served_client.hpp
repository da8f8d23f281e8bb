// ServedClient: one query client as its server sees it (docs/compatibility/edge-wire.md 10.1).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <poll.h>

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "transport/edge/message_connection.hpp"
#include "transport/edge/request.hpp"
#include "transport/edge/send_queue.hpp"

namespace weir::edge {

struct ClientOptions {
  // The form of the headers of clients. Nullopt: a greeting that those of 168 and 2088 bytes
  // understand; they decide.
  std::optional<wire::HeaderForm> form{};
  uint64_t max_message_bytes = uint64_t{64} << 20;
  QueueLimits responses{};
  // How long a client may wait for the greeting, pause within a message, and not read its
  // responses; 0 = no limit.
  std::chrono::milliseconds timeout{10000};
  // Whether the responses of a client may go to this other IPv4 address; empty: they may not.
  std::function<bool(const std::string& address)> allows_callback{};
};

// Used under the listener's lock, but read(). Nothing here blocks. What is returned as a text is
// why the client is refused.
class ServedClient {
 public:
  using Refusal = std::optional<std::string>;
  enum class State {
    Waiting,     // for the caps that it is greeted with
    Greeted,     // its HOST_INFO has to come
    Connecting,  // to its own listener, for the responses
    Ready,
    Gone
  };

  // `options` must outlive it. `a`: the connection that the client opened. `counters` of its
  // requests; one that ends wakes `wake` if it waits for that.
  ServedClient(Descriptor a, int64_t id, const ClientOptions& options,
               std::shared_ptr<RequestCounters> counters,
               std::shared_ptr<transport::WakeEvent> wake);

  int64_t id() const noexcept { return id_; }
  const std::string& address() const noexcept { return address_; }
  State state() const noexcept { return state_; }
  const std::shared_ptr<ClientLoad>& load() const noexcept { return load_; }
  bool is_gone() const noexcept { return state_ == State::Gone; }
  void set_gone() noexcept;
  // When it is refused unless it does what is due; nullopt: it need not do anything.
  io::Deadline deadline() const;
  // Why it is refused then.
  std::string reason_of_deadline() const;
  // Since when it has sent nothing and waits for nothing; nullopt: it does, it is not read, or its
  // handshake is not complete.
  io::Deadline silent_since() const;
  bool has_sent_a_request() const noexcept { return has_sent_a_request_; }

  // Announces the caps. Errors: those of wire::text_message().
  Status greet(const std::string& capability);
  bool has_responses() const noexcept { return !responses_.empty(); }
  // Bytes of the message that arrives.
  uint64_t partial_bytes() const noexcept { return a_.partial_bytes(); }

  static constexpr size_t kSockets = 2;  // for requests and for responses
  // `reading`: whether requests are read in this turn.
  void watch(bool reading, std::vector<pollfd>* watched);
  using Step = MessageConnection::Step;
  struct Input {
    Result<Step> requests = Step{}, responses = Step{};  // of either connection
  };
  // Reads what has arrived, at most one message of each connection. The thread that calls watch(),
  // without the lock.
  Input read(const pollfd* events);
  // Handles it, sends, and goes on with the second connection.
  Refusal attend(const pollfd* events, Input input, std::shared_ptr<Request>* request);
  // Queues a response. False: the queue is full. Errors: those of wire::write_header().
  Result<bool> queue_response(const std::vector<std::span<const std::byte>>& memories,
                              std::shared_ptr<const void> owner, const std::string& sequence);
  // Sends what the sockets take.
  void send();
  // Reports to the client that this end closes.
  void send_errors() noexcept;

 private:
  Refusal take(Result<Step> step, std::shared_ptr<Request>* request);
  Refusal host_info(const wire::EdgeMessage& message);
  Refusal end_connecting();

  const int64_t id_;
  const ClientOptions& options_;
  MessageConnection a_;                   // that the client opened; only read() reads
  std::unique_ptr<MessageConnection> b_;  // to its own listener: it sends nothing but ERROR
  const std::string address_;
  State state_ = State::Waiting;
  std::chrono::steady_clock::time_point since_ = std::chrono::steady_clock::now();  // of the state
  wire::HeaderForm form_;
  SendQueue greeting_, responses_;
  bool has_sent_a_request_ = false;
  std::chrono::steady_clock::time_point answered_ = since_;
  // Of the thread that calls watch() and read().
  bool reading_ = true, reads_responses_ = false;
  std::chrono::steady_clock::time_point last_bytes_ = since_;
  const std::shared_ptr<ClientLoad> load_ = std::make_shared<ClientLoad>();
  const std::shared_ptr<RequestCounters> counters_;
  const std::shared_ptr<transport::WakeEvent> wake_;
};

}  // namespace weir::edge
