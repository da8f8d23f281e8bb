// Receives calls by gRPC's generic service, whose messages are bytes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/listener.hpp"

#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/resource_quota.h>

#include <algorithm>
#include <atomic>
#include <optional>

#include "net/admission.hpp"
#include "net/grpc_bytes.hpp"
#include "net/server_security.hpp"

namespace weir::net {
namespace {

using SystemClock = std::chrono::system_clock;
constexpr int kMostMetadataBytes = 16 << 10, kHandshakeMs = 2000, kUnreadBytes = 64 << 10;
constexpr int kLeastPingMs = 100;  // of clients that watch this server (weir_keepalive)
constexpr std::chrono::milliseconds kEndOfCalls{500};

std::string text_of(const grpc::string_ref& text) {
  return {text.data(), text.size()};
}

std::string metadata_of(const grpc::CallbackServerContext& context, const char* key) {
  const auto found = context.client_metadata().find(key);
  return found == context.client_metadata().end() ? "" : text_of(found->second);
}

Call::Clock::time_point deadline_of(const grpc::CallbackServerContext& context) {
  const auto left = context.deadline() - SystemClock::now();
  if (left > std::chrono::hours(24 * 365)) return Call::Clock::time_point::max();
  return Call::Clock::now() + std::chrono::duration_cast<Call::Clock::duration>(left);
}

AdmissionLimits admission_limits(const ListenOptions& options) {
  return {.requests = options.most_requests,
          .connections = options.most_connections,
          .address_connections = options.most_address_connections,
          .address_bytes = options.most_address_bytes,
          .message_bytes = options.most_bytes};
}

// What all calls of a listener share.
struct Rules {
  Rules(const ListenOptions& options, ServerSecrets read, Listener::Handler handle)
      : secrets(std::move(read)),
        peers(options.security.peers),
        admission(admission_limits(options)),
        handler(std::move(handle)) {}

  // Why a call is refused before its request is read.
  std::optional<grpc::Status> check(const grpc::CallbackServerContext& context) const {
    if (!secrets.tokens.empty() && !has_token(secrets, metadata_of(context, "authorization")))
      return grpc::Status(grpc::StatusCode::UNAUTHENTICATED,
                          "a token is needed: metadata authorization: Bearer TOKEN");
    if (peers.empty()) return std::nullopt;
    const auto auth = context.auth_context();
    for (const auto& name : auth->FindPropertyValues(GRPC_X509_SAN_PROPERTY_NAME))
      if (std::find(peers.begin(), peers.end(), text_of(name)) != peers.end()) return std::nullopt;
    return grpc::Status(grpc::StatusCode::PERMISSION_DENIED,
                        "no name of the client's certificate is allowed (tls-peers)");
  }

  const ServerSecrets secrets;
  const std::vector<std::string> peers;
  Admission admission;
  const Listener::Handler handler;
  std::atomic<uint64_t> not_allowed{0};
};

// What a call and its reactor share.
struct Progress {
  std::atomic<bool> cancelled{false}, ended{false};
};

// gRPC's side of a call. It exists until OnDone(), which follows finish().
class Reactor final : public grpc::ServerGenericBidiReactor {
 public:
  Reactor(grpc::GenericCallbackServerContext* context, Rules* rules)
      : context_(context), rules_(rules), peer_(context->peer()) {
    if (auto refused = rules->check(*context)) {
      ++rules->not_allowed;
      refuse(*refused);
      return;
    }
    admitted_ = true;  // before the call may start to read, on another thread
    if (auto why = rules->admission.enter(peer_, this, [this] { StartRead(&request_); })) {
      admitted_ = false;
      refuse({grpc::StatusCode::RESOURCE_EXHAUSTED, *why});
    }
  }
  void OnReadDone(bool read) override;
  void OnCancel() override {
    progress_->cancelled = true;
    if (admitted_ && rules_->admission.forget(peer_, this))
      refuse({grpc::StatusCode::CANCELLED, "the call was cancelled before it had room"});
  }
  void OnDone() override { delete this; }

  // Call once, by the one that set `ended`.
  void finish(const grpc::Status& status, const std::string& trace_parent,
              std::optional<grpc::ByteBuffer> answer) {
    // Before the answer: with it the client may send its next request.
    if (admitted_) rules_->admission.leave(peer_, bytes_);
    if (!trace_parent.empty()) context_->AddTrailingMetadata("traceparent", trace_parent);
    if (!answer) return Finish(status);
    answer_ = *std::move(answer);
    StartWriteAndFinish(&answer_, grpc::WriteOptions(), status);
  }
  const grpc::GenericCallbackServerContext& context() const { return *context_; }
  const std::string& peer() const { return peer_; }

 private:
  void refuse(const grpc::Status& status) {
    if (!progress_->ended.exchange(true)) finish(status, "", std::nullopt);
  }

  grpc::GenericCallbackServerContext* const context_;
  Rules* const rules_;
  const std::string peer_;
  bool admitted_ = false;
  uint64_t bytes_ = 0;  // of the request
  const std::shared_ptr<Progress> progress_ = std::make_shared<Progress>();
  grpc::ByteBuffer request_, answer_;
};

class GrpcCall final : public Call {
 public:
  GrpcCall(Reactor* reactor, std::shared_ptr<Progress> progress, ReceivedMessage request)
      : reactor_(reactor), progress_(std::move(progress)) {
    method_ = reactor->context().method();
    peer_ = reactor->peer();
    trace_parent_ = metadata_of(reactor->context(), "traceparent");
    deadline_ = deadline_of(reactor->context());
    request_ = std::move(request.chunks);
    memory_ = std::move(request.memory);
  }
  GrpcCall(const GrpcCall&) = delete;
  GrpcCall& operator=(const GrpcCall&) = delete;
  ~GrpcCall() override { end({grpc::StatusCode::ABORTED, "the call was dropped"}, std::nullopt); }

  bool cancelled() const noexcept override { return progress_->cancelled; }
  bool answer(const Pieces& pieces, const std::shared_ptr<const void>& memory) override {
    return end(grpc::Status::OK, message_of(pieces, memory));
  }
  bool fail(CallStatus status, const std::string& message) override {
    return end({static_cast<grpc::StatusCode>(status), message}, std::nullopt);
  }

 private:
  bool end(const grpc::Status& status, std::optional<grpc::ByteBuffer> answer) {
    if (progress_->ended.exchange(true)) return false;
    reactor_->finish(status, trace_parent_, std::move(answer));
    return true;
  }

  Reactor* const reactor_;  // not used after the end
  const std::shared_ptr<Progress> progress_;
};

void Reactor::OnReadDone(bool read) {
  bytes_ = read ? request_.Length() : 0;
  rules_->admission.received(peer_, bytes_);
  if (!read) return refuse({grpc::StatusCode::INVALID_ARGUMENT, "the call has no request"});
  // A call that is not handed over to the handler ends as dropped.
  try {
    auto request = received(request_);
    request_.Clear();
    if (!request) return refuse({grpc::StatusCode::INTERNAL, "the request cannot be read"});
    rules_->handler(std::make_shared<GrpcCall>(this, progress_, *std::move(request)));
  } catch (...) {
    // No member may be used here: the call may have ended, and this with it.
  }
}

class Service final : public grpc::CallbackGenericService {
 public:
  explicit Service(Rules* rules) : rules_(rules) {}
  grpc::ServerGenericBidiReactor* CreateReactor(
      grpc::GenericCallbackServerContext* context) override {
    return new Reactor(context, rules_);
  }

 private:
  Rules* const rules_;
};

std::shared_ptr<grpc::ServerCredentials> credentials_of(const ServerSecrets& secrets) {
  if (secrets.cert.empty()) return grpc::InsecureServerCredentials();
  grpc::SslServerCredentialsOptions options(
      secrets.ca.empty() ? GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE
                         : GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
  options.pem_root_certs = secrets.ca;
  options.pem_key_cert_pairs.push_back({secrets.key, secrets.cert});
  return grpc::SslServerCredentials(options);
}

void set_limits(grpc::ServerBuilder* builder, const ListenOptions& options) {
  const int most = static_cast<int>(std::min<size_t>(options.most_bytes, INT32_MAX));
  builder->SetMaxReceiveMessageSize(most);
  builder->SetMaxSendMessageSize(most);
  // A compressed message could be far larger than what was received.
  builder->SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  builder->SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
  builder->AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  builder->AddChannelArgument(GRPC_ARG_MAX_METADATA_SIZE, kMostMetadataBytes);
  builder->AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, kHandshakeMs);
  builder->AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS,
                              static_cast<int>(std::min<uint32_t>(options.idle_ms, INT32_MAX)));
  builder->AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, kLeastPingMs);
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  // What a client may send before its message is read. gRPC's probing would let it grow.
  builder->AddChannelArgument(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  builder->AddChannelArgument(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, kUnreadBytes);
  // All addresses together, as far as they are limited.
  if (options.most_connections != 0 && options.most_address_bytes != 0) {
    const uint64_t addresses =
        options.most_address_connections == 0
            ? options.most_connections
            : (options.most_connections + options.most_address_connections - 1) /
                  options.most_address_connections;
    grpc::ResourceQuota quota("weir");
    quota.Resize(addresses * std::max<uint64_t>(options.most_address_bytes, options.most_bytes));
    builder->SetResourceQuota(quota);
  }
  // Above the limit, so that calls beyond it are refused at once instead of waiting.
  if (options.most_requests != 0)
    builder->AddChannelArgument(
        GRPC_ARG_MAX_CONCURRENT_STREAMS,
        static_cast<int>(std::min(options.most_requests, 1u << 20) * 2 + 16));
}

Error unusable_address(const ListenOptions& options) {
  return {.code = Code::OPTION_VALUE,
          .what = "the address cannot be listened on",
          .offered = address_text(options),
          .needed =
              "an address of this machine, and a port that no other program uses; with TLS a "
              "certificate and a key that belong together",
          .fix = "port=0, which takes a free port"};
}

class GrpcListener final : public Listener {
 public:
  GrpcListener(const ListenOptions& options, ServerSecrets secrets, Handler handler)
      : rules_(options, std::move(secrets), std::move(handler)), service_(&rules_) {}
  GrpcListener(const GrpcListener&) = delete;
  GrpcListener& operator=(const GrpcListener&) = delete;
  ~GrpcListener() override {
    if (server_) server_->Shutdown(SystemClock::now() + kEndOfCalls);
  }

  Status start(const ListenOptions& options) {
    grpc::ServerBuilder builder;
    set_limits(&builder, options);
    builder.RegisterCallbackGenericService(&service_);
    int port = 0;
    builder.AddListeningPort(address_text(options), credentials_of(rules_.secrets), &port);
    server_ = builder.BuildAndStart();
    if (!server_ || port == 0) return unusable_address(options);
    port_ = options.unix_path.empty() ? static_cast<uint32_t>(port) : 0;
    return ok();
  }
  uint32_t port() const noexcept override { return port_; }
  uint64_t refused() const noexcept override {
    return rules_.not_allowed + rules_.admission.refused();
  }

 private:
  Rules rules_;
  Service service_;
  std::unique_ptr<grpc::Server> server_;
  uint32_t port_ = 0;
};

}  // namespace

Result<std::unique_ptr<Listener>> Listener::open(const ListenOptions& options, Handler handler) {
  auto secrets = read_secrets(options);
  if (!secrets) return secrets.error();
  auto out = std::make_unique<GrpcListener>(options, *std::move(secrets), std::move(handler));
  if (auto status = out->start(options); !status) return status.error();
  return std::unique_ptr<Listener>(std::move(out));
}

}  // namespace weir::net
