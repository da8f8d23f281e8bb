// The client of TensorService, by gRPC's generic stub, whose messages are bytes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "net/client/channel_arguments.hpp"
#include "net/protocol/grpc_bytes.hpp"
#include "net/tensor_service/tensor_endpoints.hpp"

namespace weir::net {
namespace {

using namespace std::chrono_literals;
constexpr auto kPause = 100ms;     // before the next attempt
constexpr auto kUnreachable = 1s;  // without a connection before a warning

// A call to the server. Its operations end on the thread in run(). gRPC's callbacks are not used:
// version 1.51 ends the process when a server sends headers that it also marks as trailers.
class ClientCall {
 public:
  ClientCall() = default;
  ClientCall(const ClientCall&) = delete;
  ClientCall& operator=(const ClientCall&) = delete;
  virtual ~ClientCall() = default;

  void open(grpc::GenericStub* stub, const std::string& method) {
    stream_ = stub->PrepareCall(&context_, method, &queue_);
    stream_->StartCall(start(Operation::Open));
  }
  // Blocks until the call has ended.
  grpc::Status run() {
    void* tag = nullptr;
    bool good = false, ended = false;
    while (queue_.Next(&tag, &good)) {
      const auto operation = *static_cast<const Operation*>(tag);
      if (operation == Operation::Open) opened(good);
      if (operation == Operation::Read) on_read(good);
      if (operation == Operation::Write) on_written(good);
      ended = ended || operation == Operation::Finish;
      if (pending_.fetch_sub(1) == 1 && ended) queue_.Shutdown();
    }
    return status_;
  }
  // Thread-safe.
  void cancel() {
    context_.TryCancel();
    finish();
  }

 protected:
  // Each operation has one at a time.
  enum class Operation { Open, Read, Write, WritesDone, Finish };
  using Stream = grpc::GenericClientAsyncReaderWriter;

  virtual void begin() = 0;
  virtual void leave() = 0;  // afterwards no other thread starts operations
  virtual void on_read(bool good) = 0;
  virtual void on_written(bool) {}

  Stream& stream() noexcept { return *stream_; }
  void* start(Operation operation) {
    static constinit Operation tags[] = {Operation::Open, Operation::Read, Operation::Write,
                                         Operation::WritesDone, Operation::Finish};
    ++pending_;
    return &tags[static_cast<size_t>(operation)];
  }
  // Waits for the status of the call. Thread-safe.
  void finish() {
    is_finishing_ = true;
    leave();
    const std::lock_guard lock(mutex_);
    if (is_open_ && !std::exchange(is_finished_, true))
      stream_->Finish(&status_, start(Operation::Finish));
  }

 private:
  void opened(bool good) {
    {
      const std::lock_guard lock(mutex_);
      is_open_ = true;
    }
    if (good) begin();
    if (!good || is_finishing_) finish();  // maybe by another thread, before begin()
  }

  grpc::ClientContext context_;
  grpc::CompletionQueue queue_;
  std::unique_ptr<Stream> stream_;
  grpc::Status status_;
  std::atomic<int> pending_{0};  // operations
  std::atomic<bool> is_finishing_{false};
  std::mutex mutex_;  // guards the rest
  bool is_open_ = false, is_finished_ = false;
};

// SendTensors
class SendingCall final : public ClientCall, public OutgoingStream {
 public:
  explicit SendingCall(OutgoingFrames* frames) : frames_(frames) {}
  void write(const OutgoingMessage& message) override {
    message_ = make_message({{{}, message.bytes}}, message.memory);
    stream().Write(message_, start(Operation::Write));
  }
  void end() override { stream().WritesDone(start(Operation::WritesDone)); }

 private:
  void begin() override {
    stream().Read(&response_, start(Operation::Read));
    if (!frames_->join(this)) end();
  }
  void leave() override { frames_->leave(this); }
  // The response, or the end of the call.
  void on_read(bool) override { finish(); }
  void on_written(bool good) override {
    if (!good || !frames_->written(this)) finish();
  }

  OutgoingFrames* const frames_;
  grpc::ByteBuffer message_, response_;
};

// RecvTensors
class ReceivingCall final : public ClientCall, public IncomingStream {
 public:
  ReceivingCall(IncomingFrames* frames, const TensorServiceOptions& options)
      : frames_(frames),
        peer_(address_text(options)),
        request_(make_message({{options.empty, {}}}, nullptr)) {}
  void read() override { stream().Read(&message_, start(Operation::Read)); }
  // The element ends the stream itself: there is no call to end with an error.
  void refuse(CallStatus, const std::string&) override {}

 private:
  void begin() override {
    stream().WriteLast(request_, {}, start(Operation::Write));
    frames_->join(this);
  }
  void leave() override { frames_->leave(this); }
  void on_read(bool good) override {
    if (good) {
      auto message = received(message_);
      message_.Clear();
      if (message)
        return frames_->arrived(this,
                                {std::move(message->chunks), std::move(message->memory), peer_, 0});
    }
    finish();
  }

  IncomingFrames* const frames_;
  const std::string peer_;
  grpc::ByteBuffer request_, message_;
};

// A thread that keeps a call to the server.
class Client final : public TensorEndpoint {
 public:
  Client(const TensorServiceOptions& options, OutgoingFrames* outgoing, IncomingFrames* incoming)
      : options_(options),
        outgoing_(outgoing),
        incoming_(incoming),
        method_(method_path(options, outgoing ? kSendTensors : kRecvTensors)),
        channel_(grpc::CreateCustomChannel(address_text(options),
                                           grpc::InsecureChannelCredentials(),
                                           channel_arguments(options.max_bytes))),
        stub_(channel_),
        thread_([this] { run(); }) {}
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  ~Client() override {
    {
      std::lock_guard lock(mutex_);
      stopping_ = true;
      if (call_) call_->cancel();
    }
    if (outgoing_) outgoing_->close();
    changed_.notify_all();
    thread_.join();
  }
  uint32_t port() const noexcept override { return options_.port; }

 private:
  void run() {
    while (!stopping_) {
      if (!is_connected()) continue;
      const auto status = call();
      if (stopping_ || !goes_on(status)) return;
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, kPause, [this] { return stopping_.load(); });
    }
  }

  bool is_connected() {
    const auto since = std::chrono::steady_clock::now();
    while (!stopping_) {
      if (channel_->WaitForConnected(std::chrono::system_clock::now() + kPause)) return true;
      if (std::chrono::steady_clock::now() - since > kUnreachable)
        warn("nothing answers at this address");
    }
    return false;
  }

  grpc::Status call() {
    std::unique_ptr<ClientCall> call;
    if (outgoing_)
      call = std::make_unique<SendingCall>(outgoing_);
    else
      call = std::make_unique<ReceivingCall>(incoming_, options_);
    {
      std::lock_guard lock(mutex_);
      if (stopping_) return grpc::Status::CANCELLED;
      call_ = call.get();
      call->open(&stub_, method_);
    }
    const auto since = std::chrono::steady_clock::now();
    auto status = call->run();
    if (std::chrono::steady_clock::now() - since > kUnreachable) warned_ = false;
    std::lock_guard lock(mutex_);
    call_ = nullptr;
    return status;
  }

  // What the end of a call means. False when there is to be no other one. After the end of the
  // stream, waits for its restart.
  bool goes_on(const grpc::Status& status) {
    if (status.ok() && incoming_) {
      incoming_->end();
      return false;
    }
    if (status.ok()) return outgoing_->wait_until_needed();
    if (to_outcome(static_cast<int>(status.error_code())) == Outcome::Lost) {
      warn(status.error_message());
      return true;
    }
    const Error error{.code = Code::SERVER_REFUSED,
                      .what = "the server " + address_text(options_) + " refused the call",
                      .offered = method_ + ": " + status.error_message(),
                      .needed = "a server that accepts this call"};
    if (outgoing_) outgoing_->fail(error);
    if (incoming_) incoming_->fail(error);
    return false;
  }

  // Once until a call has lasted.
  void warn(const std::string& why) {
    if (std::exchange(warned_, true) || !options_.warn) return;
    options_.warn(
        {.code = Code::SERVER_UNREACHABLE,
         .what = "the server " + address_text(options_) +
                 " cannot be reached; the element tries again until it can",
         .offered = why.empty() ? "the connection ended" : why,
         .needed = "a server with the method " + method_,
         .fix = outgoing_ ? "start a pipeline with tensor_src_grpc server=true on that machine"
                          : "start a pipeline with tensor_sink_grpc server=true on that machine"});
  }

  const TensorServiceOptions options_;
  OutgoingFrames* const outgoing_;
  IncomingFrames* const incoming_;
  const std::string method_;
  const std::shared_ptr<grpc::Channel> channel_;
  grpc::GenericStub stub_;
  std::atomic<bool> stopping_{false};
  std::mutex mutex_;  // guards call_
  std::condition_variable changed_;
  ClientCall* call_ = nullptr;
  bool warned_ = false;  // used by the thread
  std::thread thread_;   // the last member
};

}  // namespace

std::unique_ptr<TensorEndpoint> connect_tensors(const TensorServiceOptions& options,
                                                OutgoingFrames* outgoing,
                                                IncomingFrames* incoming) {
  return std::make_unique<Client>(options, outgoing, incoming);
}

}  // namespace weir::net
