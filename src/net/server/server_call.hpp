// ServerReactor: gRPC's side of one call of a client, and what all calls of a listener share.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <grpcpp/alarm.h>
#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/grpcpp.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "net/protocol/token_file.hpp"
#include "net/server/admission.hpp"
#include "net/server/connection_acceptor.hpp"
#include "net/server/listener.hpp"

namespace weir::net {

// What all calls of a listener share.
struct ServerRules {
  // `token_file` may be null: then clients need no token.
  ServerRules(const ListenOptions& options, std::unique_ptr<TokenFile> token_file,
              Listener::Handler handle);
  // Returns why a call is refused before its request is read.
  std::optional<grpc::Status> check(const grpc::CallbackServerContext& context) const;

  const std::unique_ptr<TokenFile> tokens;
  const std::vector<std::string> peers;
  Admission admission;
  std::unique_ptr<ConnectionAcceptor> connections;  // set before calls come
  const std::chrono::milliseconds time_limit;       // of a message, and of reading a response
  const Listener::Handler handler;
  std::atomic<uint64_t> not_allowed{0};
};

// What a call and its reactor share.
struct CallState {
  std::mutex mutex;    // guards the rest, and members of the reactor
  bool ended = false;  // from then on only gRPC uses the reactor, which deletes itself
  bool done = false;   // the reactor and its context are gone
  std::atomic<bool> cancelled{false};
};

class ServerReactor final : public grpc::ServerGenericBidiReactor {
 public:
  ServerReactor(grpc::GenericCallbackServerContext* context, ServerRules* rules);
  void OnReadDone(bool read) override;
  void OnWriteDone(bool written) override;
  void OnCancel() override;
  void OnDone() override;

  const grpc::GenericCallbackServerContext& context() const { return *context_; }
  const std::string& peer() const { return peer_; }
  bool is_stream() const { return kind_ == CallKind::Stream; }
  // Ends the call, unless it has ended: then it returns false. `reactor` exists while the call has
  // not ended.
  static bool end(ServerReactor* reactor, const std::shared_ptr<CallState>& state,
                  const grpc::Status& status, std::optional<grpc::ByteBuffer> response = {});
  // Sends a message of a stream that has not ended, in the place of one that waits to be sent. Call
  // it under the lock of the state.
  void send(const grpc::ByteBuffer& message);
  // Sends the response to a message of a stream, on the thread of the handler, and receives the
  // next message after it.
  void respond_to_message(const grpc::ByteBuffer& message);

 private:
  void refuse(const grpc::Status& status) { end(this, state_, status); }
  void read();
  void wait_for_message(Call::Clock::time_point began);
  void cancel_later_if_unread();
  void leave(uint64_t response_bytes);

  grpc::GenericCallbackServerContext* const context_;
  ServerRules* const rules_;
  const std::string peer_;
  const CallKind kind_;
  const std::shared_ptr<CallState> state_ = std::make_shared<CallState>();
  grpc::ByteBuffer request_, sent_;
  bool admitted_ = false;
  // Guarded by the mutex of the state.
  bool writing_ = false, reads_on_ = false;
  uint64_t bytes_ = 0;     // of the message that was received, and of the last response
  uint64_t messages_ = 0;  // that were received
  std::optional<grpc::ByteBuffer> next_;
  std::optional<grpc::Status> last_;       // sent after the message that is being sent
  std::unique_ptr<grpc::Alarm> patience_;  // for the next message
  std::unique_ptr<grpc::Alarm> unread_;    // for a client that does not read its response
};

}  // namespace weir::net
