// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/server/server_call.hpp"

#include <algorithm>

#include "net/protocol/grpc_bytes.hpp"

namespace weir::net {
namespace {

using SystemClock = std::chrono::system_clock;
// A client that begins a call and sends no message gives back its place. A large message may take
// longer, while as many bytes come in this time.
constexpr std::chrono::seconds kMessageWait{10};
constexpr uint64_t kBytesInWait = 64 << 10;

std::string to_string(const grpc::string_ref& text) {
  return {text.data(), text.size()};
}

std::string get_metadata(const grpc::CallbackServerContext& context, const char* key) {
  const auto found = context.client_metadata().find(key);
  return found == context.client_metadata().end() ? "" : to_string(found->second);
}

std::string get_trace_parent(const grpc::CallbackServerContext& context) {
  std::string text = get_metadata(context, "traceparent");
  return is_trace_parent(text) ? text : "";
}

Call::Clock::time_point get_deadline(const grpc::CallbackServerContext& context) {
  const auto left = context.deadline() - SystemClock::now();
  if (left > std::chrono::hours(24 * 365)) return Call::Clock::time_point::max();
  return Call::Clock::now() + std::chrono::duration_cast<Call::Clock::duration>(left);
}

AdmissionLimits admission_limits(const ListenOptions& options) {
  return {.requests = options.max_requests,
          .connections = options.max_connections,
          .address_connections = options.max_address_connections,
          .address_bytes = options.max_address_bytes,
          .message_bytes = options.max_bytes};
}

class GrpcCall final : public Call {
 public:
  GrpcCall(ServerReactor* reactor, std::shared_ptr<CallState> state, ReceivedMessage request)
      : reactor_(reactor), state_(std::move(state)), is_stream_(reactor->is_stream()) {
    method_ = reactor->context().method();
    peer_ = reactor->peer();
    trace_parent_ = get_trace_parent(reactor->context());
    deadline_ = get_deadline(reactor->context());
    request_ = std::move(request.chunks);
    memory_ = std::move(request.memory);
  }
  GrpcCall(const GrpcCall&) = delete;
  GrpcCall& operator=(const GrpcCall&) = delete;
  ~GrpcCall() override {
    if (!answered_) end({grpc::StatusCode::ABORTED, "the call was dropped"}, std::nullopt);
  }

  bool cancelled() const noexcept override { return state_->cancelled; }
  bool ended() const noexcept override {
    std::lock_guard lock(state_->mutex);
    return state_->ended;
  }
  bool respond(const Pieces& pieces, const std::shared_ptr<const void>& memory) override {
    if (!is_stream_) return end(grpc::Status::OK, make_message(pieces, memory));
    if (std::exchange(answered_, true)) return false;
    reactor_->respond_to_message(make_message(pieces, memory));
    return true;
  }
  bool send(const Pieces& pieces) override {
    std::lock_guard lock(state_->mutex);
    if (state_->ended || !is_stream_) return false;
    reactor_->send(make_message(pieces, nullptr));
    return true;
  }
  bool fail(CallStatus status, const std::string& message) override {
    return end({static_cast<grpc::StatusCode>(status), message}, std::nullopt);
  }

 private:
  bool end(const grpc::Status& status, std::optional<grpc::ByteBuffer> response) {
    return ServerReactor::end(reactor_, state_, status, std::move(response));
  }

  ServerReactor* const reactor_;  // not used after the end
  const std::shared_ptr<CallState> state_;
  const bool is_stream_;
  bool answered_ = false;  // a message of a stream
};

}  // namespace

ServerRules::ServerRules(const ListenOptions& options, std::unique_ptr<TokenFile> token_file,
                         Listener::Handler handle)
    : tokens(std::move(token_file)),
      peers(options.security.peers),
      admission(admission_limits(options)),
      time_limit(options.idle_ms),
      handler(std::move(handle)) {}

std::optional<grpc::Status> ServerRules::check(const grpc::CallbackServerContext& context) const {
  if (tokens && !tokens->allows(get_metadata(context, "authorization")))
    return grpc::Status(grpc::StatusCode::UNAUTHENTICATED,
                        "a token is needed: metadata authorization: Bearer TOKEN");
  if (peers.empty()) return std::nullopt;
  const auto auth = context.auth_context();
  for (const auto& name : auth->FindPropertyValues(GRPC_X509_SAN_PROPERTY_NAME))
    if (std::find(peers.begin(), peers.end(), to_string(name)) != peers.end()) return std::nullopt;
  return grpc::Status(grpc::StatusCode::PERMISSION_DENIED,
                      "no name of the client's certificate is allowed (tls-peers)");
}

ServerReactor::ServerReactor(grpc::GenericCallbackServerContext* context, ServerRules* rules)
    : context_(context),
      rules_(rules),
      peer_(context->peer()),
      kind_(is_stream_method(context->method()) ? CallKind::Stream : CallKind::Request) {
  rules->connections->call_began(peer_);
  if (auto refused = rules->check(*context)) {
    ++rules->not_allowed;
    refuse(*refused);
  } else if (auto why = rules->admission.enter(peer_, kind_)) {
    refuse({grpc::StatusCode::RESOURCE_EXHAUSTED, *why});
  } else {
    admitted_ = true;
    read();
  }
}

void ServerReactor::read() {
  const auto start = [this, state = state_, rules = rules_, peer = peer_] {
    {
      std::lock_guard lock(state->mutex);
      if (!state->ended) {
        wait_for_message(Call::Clock::now());
        return StartRead(&request_);
      }
    }
    rules->admission.received(peer, 0);
  };
  if (auto why = rules_->admission.read(peer_, this, start))
    refuse({grpc::StatusCode::RESOURCE_EXHAUSTED, *why});
}

// Runs under the lock of the state. Ends the call if its message does not come.
void ServerReactor::wait_for_message(Call::Clock::time_point began) {
  patience_ = std::make_unique<grpc::Alarm>();
  const auto late = [this, state = state_, rules = rules_, peer = peer_, began, had = messages_,
                     bytes = rules_->connections->bytes_received(peer_)](bool expired) {
    {
      std::lock_guard lock(state->mutex);
      if (!expired || state->ended || messages_ != had) return;
      const auto now = rules->connections->bytes_received(peer);
      const bool is_slow = now && bytes && *now < *bytes + kBytesInWait;
      if (!is_slow && !is_stream() && Call::Clock::now() - began < rules->time_limit)
        return wait_for_message(began);
    }
    end(this, state,
        {grpc::StatusCode::DEADLINE_EXCEEDED, "the message of the call did not come in time"});
  };
  patience_->Set(SystemClock::now() + kMessageWait, late);
}

// Runs under the lock of the state, when the call ends: a client that reads nothing would keep its
// response in memory.
void ServerReactor::cancel_later_if_unread() {
  unread_ = std::make_unique<grpc::Alarm>();
  unread_->Set(SystemClock::now() + rules_->time_limit,
               [context = context_, state = state_](bool expired) {
                 std::lock_guard lock(state->mutex);
                 if (expired && !state->done) context->TryCancel();
               });
}

// Runs before the response is sent: with it the client may send its next request.
void ServerReactor::leave(uint64_t response_bytes) {
  if (!admitted_) return;
  rules_->admission.forget(peer_, this);
  rules_->admission.begin_response(peer_, kind_, response_bytes);
  bytes_ += response_bytes;
}

void ServerReactor::OnDone() {
  {
    std::lock_guard lock(state_->mutex);
    state_->done = true;
  }
  sent_.Clear();
  rules_->connections->call_ended(peer_);
  if (admitted_) rules_->admission.end_response(peer_, bytes_);
  delete this;
}

bool ServerReactor::end(ServerReactor* reactor, const std::shared_ptr<CallState>& state,
                        const grpc::Status& status, std::optional<grpc::ByteBuffer> response) {
  {
    std::lock_guard lock(state->mutex);
    if (std::exchange(state->ended, true)) return false;
    reactor->cancel_later_if_unread();
    if (reactor->writing_) {
      reactor->last_ = status;
      return true;
    }
  }
  reactor->leave(response ? response->Length() : 0);
  const std::string trace_parent = get_trace_parent(*reactor->context_);
  if (reactor->admitted_ && !trace_parent.empty())
    reactor->context_->AddTrailingMetadata("traceparent", trace_parent);
  if (!response) {
    reactor->Finish(status);
  } else {
    reactor->sent_ = *std::move(response);
    reactor->StartWriteAndFinish(&reactor->sent_, grpc::WriteOptions(), status);
  }
  return true;
}

void ServerReactor::send(const grpc::ByteBuffer& message) {
  if (writing_) {
    next_ = message;
    return;
  }
  writing_ = true;
  sent_ = message;
  StartWrite(&sent_);
}

void ServerReactor::respond_to_message(const grpc::ByteBuffer& message) {
  uint64_t bytes = 0;
  {
    std::lock_guard lock(state_->mutex);
    if (state_->ended) return;
    bytes = std::exchange(bytes_, 0);
    reads_on_ = true;
    send(message);
  }
  rules_->admission.release(peer_, bytes);
}

void ServerReactor::OnWriteDone(bool written) {
  std::unique_lock lock(state_->mutex);
  writing_ = false;
  if (state_->ended) {
    lock.unlock();
    leave(0);
    return Finish(*last_);
  }
  if (written && next_) {
    writing_ = true;
    sent_ = *std::exchange(next_, std::nullopt);
    return StartWrite(&sent_);
  }
  const bool reads_on = std::exchange(reads_on_, false);
  lock.unlock();
  if (!written) return refuse(grpc::Status::CANCELLED);
  if (reads_on) read();
}

void ServerReactor::OnReadDone(bool read) {
  const uint64_t bytes = read ? request_.Length() : 0;
  if (read) rules_->connections->message_came(peer_);
  rules_->admission.received(peer_, bytes);
  const auto state = state_;  // this may be gone after the end
  bool ended = false, first = false;
  {
    std::lock_guard lock(state->mutex);
    ended = state->ended;
    if (!ended) bytes_ = bytes;
    first = messages_ == 0;
    if (read) ++messages_;
  }
  if (ended) return rules_->admission.release(peer_, bytes);
  if (!read && !first) return refuse(grpc::Status::OK);
  if (!read) return refuse({grpc::StatusCode::INVALID_ARGUMENT, "the call has no request"});
  // A call that is not handed over to the handler ends as dropped.
  try {
    auto request = received(request_);
    request_.Clear();
    if (!request) return refuse({grpc::StatusCode::INTERNAL, "the request cannot be read"});
    rules_->handler(std::make_shared<GrpcCall>(this, state, *std::move(request)));
  } catch (...) {
    // No member may be used here: the call may have ended, and this with it.
  }
}

void ServerReactor::OnCancel() {
  state_->cancelled = true;
  // Calls that have been received are ended by those who have them.
  if (rules_->admission.forget(peer_, this) || is_stream())
    refuse({grpc::StatusCode::CANCELLED, "the call was cancelled"});
}

}  // namespace weir::net
