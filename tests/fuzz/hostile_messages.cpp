// SPDX-License-Identifier: LGPL-2.1-or-later
#include "hostile_messages.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <span>
#include <string>
#include <utility>

#include "core/wire/edge_capability.hpp"
#include "core/wire/edge_metadata.hpp"
#include "core/wire/mqtt_frame.hpp"
#include "core/wire/mqtt_header.hpp"
#include "fuzz_input.hpp"
#include "net/protocol/wire.hpp"
#include "transport/local/local_message.hpp"

namespace weir::fuzz {
namespace {

constexpr uint32_t kManyBytes = 60u << 20;  // that are announced and do not come
constexpr size_t kBlockBytes = 4096;

Bytes to_bytes(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}
std::string big_endian(uint64_t number, size_t bytes) {
  std::string out;
  for (size_t i = bytes; i > 0; --i) out += static_cast<char>(number >> (8 * (i - 1)));
  return out;
}

// ---- NNStreamer's protocol over TCP ------------------------------------------------------------

using wire::Command;
using wire::HeaderForm;

Bytes edge_frame(const Conversation& to, std::vector<uint64_t> sizes, size_t sent) {
  wire::EdgeMetadata metadata;
  (void)metadata.set("client_id", std::to_string(to.client_id));
  (void)metadata.set("weir.seq", std::to_string(to.number));
  const auto pairs = metadata.encode();
  Bytes out = *wire::write_header(HeaderForm::Bytes2088, {.command = Command::TransferData,
                                                          .client_id = to.client_id,
                                                          .sizes = std::move(sizes),
                                                          .metadata_bytes = pairs.size()});
  const auto frame = to_bytes(kHostileFrame);
  for (size_t i = 0; i < sent; ++i) out.push_back(frame[i % frame.size()]);
  out.insert(out.end(), pairs.begin(), pairs.end());
  return out;
}
Bytes edge_text(const Conversation& to, Command command, const std::string& text,
                HeaderForm form = HeaderForm::Bytes2088) {
  return *wire::text_message(form, command, to.client_id, text);
}

Bytes edge_message(Protocol protocol, uint32_t kind, Conversation* c) {
  const std::string listener = "localhost:" + std::to_string(c->listener);
  switch (kind % 10) {
    case kGreeting:
      return edge_text(*c, Command::Capability,
                       protocol == Protocol::Query
                           ? *wire::query_capability_text({kFrameCaps, kFrameCaps})
                           : *wire::publisher_capability_text(kFrameCaps));
    case kFrame:
      ++c->number;
      return edge_frame(*c, {kHostileFrame.size()}, kHostileFrame.size());
    case kHostInfo:
      return edge_text(*c, Command::HostInfo, listener);
    case 3:
      return edge_text(*c, Command::Capability, *wire::publisher_capability_text(""));
    case 4:
      return wire::error_message(HeaderForm::Bytes2088);
    case 5:
      return edge_frame(*c, {kManyBytes}, 0);
    case 6:
      return edge_frame(*c, std::vector<uint64_t>(255, 1), 255);
    case 7:
      return edge_frame(*c, {1 << 18}, 1 << 18);
    case 8:
      return edge_text(*c, Command::HostInfo, listener, HeaderForm::Bytes168);
    default:
      return edge_text(*c, Command::Capability, "");
  }
}

// ---- gRPC --------------------------------------------------------------------------------------

enum Http2 : uint8_t { Data, Headers, Priority, Reset, Settings, Push, Ping, GoAway, Window, More };
constexpr uint8_t kEndStream = 1, kEndHeaders = 4;

std::string http2_frame(Http2 kind, uint8_t flags, uint32_t stream, std::string_view payload) {
  return big_endian(payload.size(), 3) + static_cast<char>(kind) + static_cast<char>(flags) +
         big_endian(stream, 4) + std::string(payload);
}
// HPACK: a literal that is not indexed.
std::string http2_header(std::string_view name, std::string_view value) {
  return '\0' + big_endian(name.size(), 1) + std::string(name) + big_endian(value.size(), 1) +
         std::string(value);
}

std::string metadata_response() {
  std::string tensor, out;
  net::put_bytes(&tensor, 1, "x");
  net::put_bytes(&tensor, 2, "UINT8");
  net::put_bytes(&tensor, 3, "\4");
  net::put_bytes(&out, 1, "m");
  net::put_bytes(&out, 4, tensor);
  net::put_bytes(&out, 5, tensor);
  return out;
}
// A request and a response have the same fields for their tensors.
std::string inference() {
  std::string tensor, out;
  net::put_bytes(&tensor, 1, "x");
  net::put_bytes(&tensor, 2, "UINT8");
  net::put_bytes(&tensor, 3, "\4");
  net::put_bytes(&out, 1, "m");
  net::put_bytes(&out, 5, tensor);
  return out;
}
std::string inference_request() {
  std::string out = inference();
  net::put_bytes(&out, 7, kHostileFrame);
  return out;
}
std::string inference_response() {
  std::string out = inference();
  net::put_bytes(&out, 6, kHostileFrame);
  return out;
}

std::string grpc_message(Protocol protocol, const Conversation& c) {
  std::string message(tensor_message(kHostileFrame));
  if (protocol == Protocol::Inference && c.is_client) message = inference_request();
  if (protocol == Protocol::Inference && !c.is_client)
    message = c.number == 1 ? metadata_response() : inference_response();
  return '\0' + big_endian(message.size(), 4) + message;
}
std::string grpc_headers(Protocol protocol, const Conversation& c) {
  const std::string content = http2_header("content-type", "application/grpc");
  if (!c.is_client) return http2_header(":status", "200") + content;
  const char* method = c.number % 4 == 3 ? "/nnstreamer.protobuf.TensorService/RecvTensors"
                                         : "/nnstreamer.protobuf.TensorService/SendTensors";
  if (protocol == Protocol::Inference)
    method = c.number % 8 == 7 ? "/grpc.health.v1.Health/Watch"
                               : "/inference.GRPCInferenceService/ModelInfer";
  return http2_header(":method", "POST") + http2_header(":scheme", "http") +
         http2_header(":path", method) + http2_header(":authority", "localhost") +
         http2_header("te", "trailers") + content;
}

std::string grpc_call(Protocol protocol, Conversation* c) {
  ++c->number;
  const uint32_t stream = 2 * c->number - 1;
  std::string out = http2_frame(Headers, kEndHeaders, stream, grpc_headers(protocol, *c));
  const bool ends = protocol == Protocol::Inference;  // the others are streams
  out +=
      http2_frame(Data, ends && c->is_client ? kEndStream : 0, stream, grpc_message(protocol, *c));
  if (ends && !c->is_client)
    out += http2_frame(Headers, kEndHeaders | kEndStream, stream, http2_header("grpc-status", "0"));
  return out;
}

std::string grpc_bytes(Protocol protocol, uint32_t kind, Conversation* c) {
  const uint32_t stream = c->number == 0 ? 1 : 2 * c->number - 1;
  switch (kind % 14) {
    case kGreeting:
      return (c->is_client ? "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" : "") +
             http2_frame(Settings, 0, 0, "");
    case kFrame:
      return grpc_call(protocol, c);
    case 2:
      ++c->number;
      return http2_frame(Headers, kEndHeaders, 2 * c->number - 1, grpc_headers(protocol, *c));
    case 3:
      return http2_frame(Data, 0, stream, grpc_message(protocol, *c));
    case 4:
      return http2_frame(Data, 0, stream,
                         '\0' + big_endian(kManyBytes, 4) + std::string(16000, 'x'));
    case 5:
      return http2_frame(Headers, kEndHeaders | kEndStream, stream,
                         http2_header("grpc-status", c->number % 2 ? "0" : "14"));
    case 6:
      return http2_frame(Data, kEndStream, stream, "");
    case 7:
      return http2_frame(Reset, 0, stream, big_endian(8, 4));
    case 8:
      return http2_frame(Ping, 0, 0, "12345678");
    case 9:
      return http2_frame(Settings, 0, 0, big_endian(4, 2) + big_endian(0, 4));
    case 10:
      return http2_frame(Headers, 0, stream + 2, http2_header("x", "y")) +
             http2_frame(More, 0, stream + 2, http2_header("z", std::string(120, 'z')));
    case 11:
      return http2_frame(Window, 0, 0, big_endian(0x7fffffff, 4));
    case 12:
      return http2_frame(GoAway, 0, 0, big_endian(stream, 4) + big_endian(0, 4));
    default:
      return http2_frame(Settings, 1, 0, "");
  }
}

// ---- MQTT --------------------------------------------------------------------------------------

std::string mqtt_packet(uint8_t type, std::string_view body) {
  std::string out(1, static_cast<char>(type));
  net::put_varint(&out, body.size());
  return out + std::string(body);
}
std::string mqtt_text(std::string_view text) {
  return big_endian(text.size(), 2) + std::string(text);
}
std::string mqtt_publication(const Conversation& c, int qos, std::string_view topic,
                             std::string_view payload, const std::string& properties) {
  std::string body = mqtt_text(topic);
  if (qos > 0) body += big_endian(c.number, 2);
  if (c.is_mqtt5) net::put_varint(&body, properties.size());
  if (c.is_mqtt5) body += properties;
  return mqtt_packet(static_cast<uint8_t>(0x30 | qos << 1), body + std::string(payload));
}
std::string mqtt_frame(const Conversation& c, int qos) {
  const std::string caps = '\x26' + mqtt_text("caps") + mqtt_text(kFrameCaps);
  std::string payload(kHostileFrame);
  if (!c.is_mqtt5) {
    const auto header = *wire::write_mqtt_header({.sizes = {payload.size()}, .caps = kFrameCaps});
    payload.insert(0, reinterpret_cast<const char*>(header.data()), header.size());
  }
  return mqtt_publication(c, qos, "t", payload, caps);
}
std::string many_properties() {
  std::string out;
  for (int i = 0; i < 60'000; ++i) out += std::string("\x26\0\0\0\0", 5);
  return out;
}

std::string mqtt_bytes(uint32_t kind, Conversation* c) {
  const std::string properties(c->is_mqtt5 ? 1 : 0, '\0');
  if (kind % 14 != kGreeting) ++c->number;
  const std::string number = big_endian(c->number, 2);
  switch (kind % 14) {
    case kGreeting:
      return mqtt_packet(0x20, std::string(2, '\0') + properties);
    case kFrame:
      return mqtt_frame(*c, static_cast<int>(c->number % 3));
    case kSubscribed:
      return mqtt_packet(0x90, big_endian(1, 2) + properties + '\0');
    case 3:
      return mqtt_packet(0x40, number);
    case 4:
      return mqtt_packet(0x50, number);
    case 5:
      return mqtt_packet(0x62, number);
    case 6:
      return mqtt_packet(0x70, number);
    case 7:
      return mqtt_packet(0xd0, "");
    case 8:
      return mqtt_packet(0xe0, c->is_mqtt5 ? std::string(2, '\0') : "");
    case 9:
      return mqtt_publication(*c, 0, "t", kHostileFrame, many_properties());
    case 10:  // this broker as a server
      return mqtt_publication(*c, 1, *wire::announcement_topic("1", "t"),
                              "127.0.0.1:" + std::to_string(c->listener), "");
    case 11:
      return mqtt_publication(*c, 0, "t", std::string(1 << 18, 'x'), "");
    case 12:
      return mqtt_packet(0x20, "\0\5" + properties);
    default:
      return "\x30\xff\xff\xff\x7f" + mqtt_text("t");
  }
}

// ---- streams of one machine --------------------------------------------------------------------

template <class... T>
Bytes local_message(local::Kind kind, const T&... parts) {
  isolate::MessageWriter message;
  message.begin(kind);
  (message.put(parts), ...);
  const auto bytes = message.finish();
  return {bytes.begin(), bytes.end()};
}
Bytes local_caps() {
  isolate::MessageWriter message;
  message.begin(local::Kind::Caps);
  message.text(kFrameCaps);
  const auto bytes = message.finish();
  return {bytes.begin(), bytes.end()};
}
local::FrameHead frame_head(uint64_t number, uint32_t pieces) {
  return {number, {}, pieces, 0};
}

HostileMessage local_bytes(uint32_t kind, Conversation* c) {
  using local::Kind;
  constexpr local::Greeting greeting{local::kMagic, local::kProtocol};
  const uint64_t number = kind % 10 == kGreeting ? 0 : ++c->number;
  switch (kind % 10) {
    case kGreeting:
      return c->is_client ? HostileMessage{local_message(Kind::Hello, greeting)}
                          : HostileMessage{local_message(Kind::Welcome, greeting, uint32_t{4})};
    case kFrame:
      if (c->is_client) return {local_message(Kind::Release, number)};
      return {local_message(Kind::Frame, frame_head(number, 1), local::Piece{1, 0, 4})};
    case kMemory:
      return {local_message(Kind::Block, local::BlockMessage{1, kBlockBytes}), true};
    case kCaps:
      return {local_caps()};
    case 4:
      return {local_message(Kind::Block, local::BlockMessage{number, kBlockBytes}), true};
    case 5:
      return {local_message(Kind::Forget, uint64_t{1})};
    case 6:
      return {local_message(Kind::End)};
    case 7:
      return {local_message(Kind::Leave)};
    case 8:
      return {local_message(Kind::Release, uint64_t{1})};
    default:
      return {local_message(Kind::Frame, frame_head(number, 2), local::Piece{1, kBlockBytes, 0},
                            local::Piece{1, UINT64_MAX, 2})};
  }
}

// ---- HTTP --------------------------------------------------------------------------------------

std::string http_bytes(uint32_t kind, Conversation* c) {
  switch (kind % 8) {
    case kGreeting:
      return "GET /metrics HTTP/1.1\r\n";
    case kFrame:
      ++c->number;
      return "GET /metrics HTTP/1.1\r\nHost: a\r\n\r\n";
    case 2:
      return "\r\n\r\n";
    case 3:
      return "GET /" + std::string(kBlockBytes, 'a');
    case 4:
      return "POST /metrics HTTP/1.1\r\nContent-Length: " + std::to_string(kManyBytes) + "\r\n\r\n";
    case 5:
      return "GET /metrics?" + std::to_string(++c->number) + " HTTP/1.0\r\n\r\n";
    case 6:
      return "X-" + std::to_string(++c->number) + ": " + std::string(kHostileFrame) + "\r\n";
    default:
      return "GET";
  }
}

}  // namespace

HostileMessage make_message(Protocol protocol, uint32_t kind, Conversation* conversation) {
  switch (protocol) {
    case Protocol::Stream:
    case Protocol::Query:
      return {edge_message(protocol, kind, conversation)};
    case Protocol::Mqtt:
      return {to_bytes(mqtt_bytes(kind, conversation))};
    case Protocol::Local:
      return local_bytes(kind, conversation);
    case Protocol::Http:
      return {to_bytes(http_bytes(kind, conversation))};
    default:
      return {to_bytes(grpc_bytes(protocol, kind, conversation))};
  }
}

std::string tensor_message(std::string_view frame) {
  std::string dimensions(16, '\0'), tensor, out;
  dimensions[0] = static_cast<char>(frame.size());
  net::put_number(&tensor, 2, 5);  // NNS_UINT8
  net::put_bytes(&tensor, 3, dimensions);
  net::put_bytes(&tensor, 4, frame);
  net::put_number(&out, 1, 1);
  net::put_bytes(&out, 3, tensor);
  return out;
}

int hostile_memory() {
  static const int memory = [] {
    const int out = memfd_create("hostile", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    require(ftruncate(out, kBlockBytes) == 0 && fcntl(out, F_ADD_SEALS, F_SEAL_SHRINK) == 0,
            "there is shared memory");
    return out;
  }();
  return memory;
}

}  // namespace weir::fuzz
