// A plain server and a plain client of grpc++ with the generic classes, the floor of the engine
// oip.
//
// The server has one model, x -> y, both FP32 [1,N], and answers each request with the same bytes,
// or with those that a function makes of it. It knows the protocol only as far as the engine calls
// it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "net/protocol/oip_messages.hpp"

namespace weir::bench {

constexpr int kMaxBytes = 64 << 20;

inline std::string tensor_text(const std::string& name, size_t elements) {
  std::string shape, out;
  net::put_varint(&shape, 1);
  net::put_varint(&shape, elements);
  net::put_bytes(&out, 1, name);
  net::put_bytes(&out, 2, "FP32");
  net::put_bytes(&out, 3, shape);
  return out;
}

inline grpc::ByteBuffer message(const std::string& text) {
  const grpc::Slice slice(text);
  return {&slice, 1};
}

// The end of the message's bytes, as many as there is room for in `to`. False when it cannot be
// read.
inline bool copy_end(const grpc::ByteBuffer& message, std::span<char> to) {
  std::vector<grpc::Slice> parts;
  if (!message.Dump(&parts).ok()) return false;
  size_t skip = message.Length() - std::min(message.Length(), to.size()), at = 0;
  for (const auto& part : parts) {
    const size_t from = std::min(skip, part.size());
    std::memcpy(to.data() + at, part.begin() + from, part.size() - from);
    skip -= from, at += part.size() - from;
  }
  return true;
}

class PlainServer final : public grpc::CallbackGenericService {
 public:
  // The bytes of the output, made of the message of a request. Called on threads of gRPC.
  using Responder = std::function<grpc::Slice(const grpc::ByteBuffer& request)>;
  // `elements` of the output.
  explicit PlainServer(size_t elements, Responder response = nullptr) : made_(std::move(response)) {
    std::string metadata, begin, header;
    net::put_bytes(&metadata, 1, "plain");
    net::put_bytes(&metadata, 4, tensor_text("x", elements));
    net::put_bytes(&metadata, 5, tensor_text("y", elements));
    metadata_ = message(metadata);
    ready_ = message(std::string("\x08\x01", 2));
    net::put_bytes(&begin, 5, tensor_text("y", elements));
    net::put_bytes_header(&header, 6, elements * sizeof(float));
    begin_ = grpc::Slice(begin + header);
    zeros_ = grpc::Slice(std::string(elements * sizeof(float), 0));
  }

  // Prints `port PORT` and serves until the end of standard input.
  void run(const std::string& port, const std::shared_ptr<grpc::ServerCredentials>& credentials =
                                        grpc::InsecureServerCredentials()) {
    grpc::ServerBuilder builder;
    int chosen = 0;
    builder.AddListeningPort("127.0.0.1:" + port, credentials, &chosen);
    builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
    builder.SetMaxReceiveMessageSize(kMaxBytes).SetMaxSendMessageSize(kMaxBytes);
    builder.RegisterCallbackGenericService(this);
    const auto server = builder.BuildAndStart();
    std::printf("port %d\n", chosen);
    std::fflush(stdout);
    while (std::getchar() != EOF) {
    }
    server->Shutdown(std::chrono::system_clock::now());
  }

 private:
  class Call final : public grpc::ServerGenericBidiReactor {
   public:
    using Made = std::function<grpc::ByteBuffer(const grpc::ByteBuffer& request)>;
    explicit Call(Made made) : made_(std::move(made)) { StartRead(&request_); }
    void OnReadDone(bool) override {
      response_ = made_(request_);
      StartWriteAndFinish(&response_, {}, grpc::Status::OK);
    }
    void OnDone() override { delete this; }

   private:
    const Made made_;
    grpc::ByteBuffer request_, response_;
  };
  static Call* same(grpc::ByteBuffer response) {
    return new Call([response = std::move(response)](const grpc::ByteBuffer&) { return response; });
  }
  grpc::ByteBuffer make_output(const grpc::ByteBuffer& request) const {
    const grpc::Slice slices[] = {begin_, made_ ? made_(request) : zeros_};
    return {slices, 2};
  }
  grpc::ServerGenericBidiReactor* CreateReactor(
      grpc::GenericCallbackServerContext* context) override {
    const std::string method = context->method();
    if (method.ends_with("ModelInfer")) {
      ++requests_;
      return new Call([this](const grpc::ByteBuffer& request) { return make_output(request); });
    }
    if (method.ends_with("ModelMetadata")) return same(metadata_);
    if (method.ends_with("ModelReady")) return same(ready_);
    return same(message(std::to_string(requests_)));  // Requests
  }

  const Responder made_;
  grpc::Slice begin_, zeros_;
  grpc::ByteBuffer metadata_, ready_;
  std::atomic<uint64_t> requests_{0};
};

// Calls that send the request's bytes from where they are, and copy the response into memory that
// stays.
class PlainClient {
 public:
  explicit PlainClient(const std::string& port,
                       const std::shared_ptr<grpc::ChannelCredentials>& credentials =
                           grpc::InsecureChannelCredentials()) {
    grpc::ChannelArguments arguments;
    arguments.SetMaxReceiveMessageSize(kMaxBytes);
    arguments.SetMaxSendMessageSize(kMaxBytes);
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);  // a connection of its own
    stub_ = std::make_unique<grpc::GenericStub>(
        grpc::CreateCustomChannel("ipv4:127.0.0.1:" + port, credentials, arguments));
  }

  // Any thread. The end of the response's bytes, as many as there is room for in `to`. Returns the
  // size of the response; 0 when the call fails, with `code`.
  size_t call(const char* method, const net::Pieces& request, std::span<char> to,
              grpc::StatusCode* code = nullptr) const {
    std::vector<grpc::Slice> slices;
    for (const auto& piece : request)
      slices.push_back(piece.own.empty() ? grpc::Slice(piece.borrowed.data(), piece.borrowed.size(),
                                                       grpc::Slice::STATIC_SLICE)
                                         : grpc::Slice(piece.own));
    const grpc::ByteBuffer message(slices.data(), slices.size());
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(10));
    grpc::CompletionQueue queue;
    const auto rpc =
        stub_->PrepareUnaryCall(&context, std::string(net::kService) + method, message, &queue);
    rpc->StartCall();
    grpc::ByteBuffer response;
    grpc::Status status;
    rpc->Finish(&response, &status, nullptr);
    void* tag = nullptr;
    bool done = false;
    queue.Next(&tag, &done);
    if (code) *code = status.error_code();
    if (!status.ok() || !copy_end(response, to)) return 0;
    return response.Length();
  }

 private:
  std::unique_ptr<grpc::GenericStub> stub_;
};

}  // namespace weir::bench
