// The server of TensorService, by gRPC's generic service, whose messages are bytes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <grpcpp/alarm.h>
#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/resource_quota.h>

#include <algorithm>
#include <atomic>
#include <mutex>

#include "net/protocol/grpc_bytes.hpp"
#include "net/server/admission.hpp"
#include "net/server/grpc_connections.hpp"
#include "net/server/keepalive.hpp"
#include "net/server/peer_name.hpp"
#include "net/server/server_security.hpp"
#include "net/tensor_service/tensor_endpoints.hpp"

namespace weir::net {
namespace {

constexpr std::chrono::milliseconds kEndOfCalls{500};
constexpr std::chrono::seconds kRequestWait{10};  // of RecvTensors
constexpr uint32_t kMaxStreams = 8;               // of one connection
constexpr int kMaxMetadataBytes = 16 << 10, kHandshakeMs = 2000, kIdleMs = 300'000;
constexpr int kUnreadBytes = 64 << 10;            // that a client may send before a read
constexpr size_t kMaxMemory = size_t{512} << 20;  // for what is received and not taken

grpc::ByteBuffer make_message(const std::string& bytes) {
  return net::make_message({{bytes, {}}}, nullptr);
}

// What limits the clients.
struct Guards {
  Admission admission;
  std::unique_ptr<ConnectionAcceptor> connections;  // set before calls come
};

// A call: admitted or refused, and finished once. Exists until OnDone().
class ServedCall : public grpc::ServerGenericBidiReactor {
 public:
  ServedCall(grpc::GenericCallbackServerContext* context, Guards* guards)
      : peer_(context->peer()), guards_(guards) {
    guards->connections->call_began(peer_);
  }

  bool enter() {
    auto why = guards_->admission.enter(peer_, CallKind::Stream);
    admitted_ = !why;
    if (why) finish({grpc::StatusCode::RESOURCE_EXHAUSTED, *why});
    return admitted_;
  }
  void finish(const grpc::Status& status) {
    if (!finished_.exchange(true)) Finish(status);
  }
  void OnDone() override {
    guards_->connections->call_ended(peer_);
    if (admitted_) guards_->admission.leave(peer_, CallKind::Stream);
    delete this;
  }

 protected:
  const std::string peer_;
  Guards* const guards_;
  std::atomic<bool> finished_{false};

 private:
  bool admitted_ = false;
};

// RecvTensors: the client sends Empty and receives a stream.
class SendingCall final : public ServedCall, public OutgoingStream {
 public:
  SendingCall(grpc::GenericCallbackServerContext* context, Guards* guards, OutgoingFrames* frames)
      : ServedCall(context, guards), frames_(frames) {
    if (!enter()) return;
    patience_.Set(std::chrono::system_clock::now() + kRequestWait,
                  [this, order = order_](bool expired) {
                    const std::lock_guard lock(order->mutex);
                    if (expired && !order->has_request && !order->is_gone)
                      finish({grpc::StatusCode::DEADLINE_EXCEEDED,
                              "the request of the call did not come for ten seconds"});
                  });
    StartRead(&request_);
  }

  void OnReadDone(bool read) override {
    if (!read) return finish({grpc::StatusCode::INVALID_ARGUMENT, "the call has no request"});
    const std::lock_guard lock(order_->mutex);
    order_->has_request = true;
    if (!order_->is_gone && !frames_->join(this)) finish(grpc::Status::OK);
  }
  void OnWriteDone(bool written) override {
    if (written && frames_->written(this)) return;
    frames_->leave(this);
    finish(grpc::Status::CANCELLED);
  }
  void OnCancel() override {
    const std::lock_guard lock(order_->mutex);
    order_->is_gone = true;
    // A write in progress ends too: OnWriteDone() finishes the call.
    if (!frames_->leave(this)) finish(grpc::Status::CANCELLED);
  }

  void write(const OutgoingMessage& message) override {
    message_ = net::make_message({{{}, message.bytes}}, message.memory);
    StartWrite(&message_);
  }
  void end() override { finish(grpc::Status::OK); }

  void OnDone() override {
    frames_->leave(this);
    {
      const std::lock_guard lock(order_->mutex);
      order_->is_gone = true;
    }
    ServedCall::OnDone();
  }

 private:
  // Of joining and leaving. The alarm has it too: it may ring when the call is gone.
  struct Order {
    std::mutex mutex;  // guards the rest
    bool has_request = false;
    bool is_gone = false;  // the client gave up, or the call has ended
  };
  OutgoingFrames* const frames_;
  const std::shared_ptr<Order> order_ = std::make_shared<Order>();
  grpc::ByteBuffer request_, message_;
  grpc::Alarm patience_;  // for the request
};

// SendTensors: the client sends a stream and receives Empty.
class ReceivingCall final : public ServedCall, public IncomingStream {
 public:
  ReceivingCall(grpc::GenericCallbackServerContext* context, Guards* guards, IncomingFrames* frames,
                const std::string& empty)
      : ServedCall(context, guards), frames_(frames), response_(make_message(empty)) {
    if (enter() && !frames_->join(this))
      finish({grpc::StatusCode::UNAVAILABLE, "the stream of the receiver has ended"});
  }

  void OnReadDone(bool read) override {
    if (read) {
      guards_->connections->message_came(peer_);
      auto message = received(message_);
      message_.Clear();
      if (message)
        return frames_->arrived(this,
                                {std::move(message->chunks), std::move(message->memory), peer_, 0});
    }
    if (frames_->leave(this) && !finished_.exchange(true))
      StartWriteAndFinish(&response_, grpc::WriteOptions(), grpc::Status::OK);
  }
  void OnCancel() override {
    if (frames_->leave(this)) finish(grpc::Status::CANCELLED);
  }

  void read() override { StartRead(&message_); }
  void refuse(CallStatus status, const std::string& why) override {
    finish({static_cast<grpc::StatusCode>(status), why});
  }

  void OnDone() override {
    frames_->leave(this);
    ServedCall::OnDone();
  }

 private:
  IncomingFrames* const frames_;
  grpc::ByteBuffer message_, response_;
};

class RefusedCall final : public grpc::ServerGenericBidiReactor {
 public:
  explicit RefusedCall(const grpc::Status& status) { Finish(status); }
  void OnDone() override { delete this; }
};

ListenOptions listen_options(const TensorServiceOptions& options) {
  ListenOptions out;
  out.host = options.host;
  out.port = options.port;
  out.max_bytes = options.max_bytes;
  out.max_requests = kMaxStreams;
  out.max_connections = options.max_connections;
  out.max_address_connections = options.max_address_connections;
  return out;
}

void set_limits(grpc::ServerBuilder* builder, const TensorServiceOptions& options) {
  const int max = static_cast<int>(std::min<size_t>(options.max_bytes, INT32_MAX));
  builder->SetMaxReceiveMessageSize(max);
  builder->SetMaxSendMessageSize(max);
  // A compressed message could be far larger than what was received.
  builder->SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  builder->SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
  builder->SetResourceQuota(grpc::ResourceQuota("tensors").Resize(kMaxMemory));
  const struct {
    const char* name;
    int value;
  } arguments[] = {
      {GRPC_ARG_MAX_METADATA_SIZE, kMaxMetadataBytes},
      {GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, kHandshakeMs},
      {GRPC_ARG_MAX_CONNECTION_IDLE_MS, kIdleMs},
      {GRPC_ARG_HTTP2_BDP_PROBE, 0},
      {GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, kUnreadBytes},
      {GRPC_ARG_MAX_CONCURRENT_STREAMS, static_cast<int>(max_streams(listen_options(options)))}};
  for (const auto& argument : arguments) builder->AddChannelArgument(argument.name, argument.value);
  set_keepalive(builder);
}

class Server final : public TensorEndpoint, grpc::CallbackGenericService {
 public:
  Server(const TensorServiceOptions& options, OutgoingFrames* outgoing, IncomingFrames* incoming)
      : outgoing_(outgoing),
        incoming_(incoming),
        empty_(options.empty),
        method_(method_path(options, outgoing ? kRecvTensors : kSendTensors)),
        guards_{Admission(AdmissionLimits{.streams = kMaxStreams,
                                          .connections = options.max_connections,
                                          .address_connections = options.max_address_connections}),
                nullptr},
        allows_(options.allows) {}
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  ~Server() override {
    if (incoming_) incoming_->close();
    if (guards_.connections) guards_.connections->stop();
    if (server_) server_->Shutdown(std::chrono::system_clock::now() + kEndOfCalls);
  }

  Status start(const TensorServiceOptions& options) {
    grpc::ServerBuilder builder;
    set_limits(&builder, options);
    builder.RegisterCallbackGenericService(this);
    auto connections = ConnectionAcceptor::listen(listen_options(options));
    if (!connections) return connections.error();
    guards_.connections = *std::move(connections);
    auto server =
        serve_connections(&builder, grpc::InsecureServerCredentials(), guards_.connections.get(),
                          address_text(listen_options(options)));
    if (!server) return server.error();
    server_ = *std::move(server);
    return ok();
  }
  uint32_t port() const noexcept override { return guards_.connections->port(); }

 private:
  grpc::ServerGenericBidiReactor* CreateReactor(
      grpc::GenericCallbackServerContext* context) override {
    if (context->method() != method_)
      return new RefusedCall(
          {grpc::StatusCode::UNIMPLEMENTED, "this server has the method " + method_ + " only"});
    if (allows_ && !allows_(peer_host(context->peer())))
      return new RefusedCall(
          {grpc::StatusCode::PERMISSION_DENIED, "this server does not allow your address (allow)"});
    if (outgoing_) return new SendingCall(context, &guards_, outgoing_);
    return new ReceivingCall(context, &guards_, incoming_, empty_);
  }

  OutgoingFrames* const outgoing_;
  IncomingFrames* const incoming_;
  const std::string empty_, method_;
  Guards guards_;
  const std::function<bool(const std::string&)> allows_;
  std::unique_ptr<grpc::Server> server_;
};

}  // namespace

Result<std::unique_ptr<TensorEndpoint>> serve_tensors(const TensorServiceOptions& options,
                                                      OutgoingFrames* outgoing,
                                                      IncomingFrames* incoming) {
  auto out = std::make_unique<Server>(options, outgoing, incoming);
  if (auto status = out->start(options); !status) return status.error();
  return std::unique_ptr<TensorEndpoint>(std::move(out));
}

}  // namespace weir::net
