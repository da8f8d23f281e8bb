// What a hostile peer sends: messages of each protocol that are valid where nothing else is said.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace weir::fuzz {

using Bytes = std::vector<std::byte>;

inline constexpr char kFrameCaps[] =
    "other/tensors,format=static,num_tensors=1,dimensions=(string)4,types=(string)uint8,"
    "framerate=30/1";
// Frames of honest peers, and those of hostile ones.
inline constexpr std::string_view kHonestFrame = "good", kHostileFrame = "evil";

enum class Protocol : uint8_t {
  Stream,         // of NNStreamer, over TCP
  Query,          // the same
  TensorService,  // gRPC
  Inference,      // gRPC
  Mqtt,
  Local,
  Http  // the page of metrics
};

// What the next message of one connection depends on.
struct Conversation {
  uint32_t number = 0;     // of requests, calls, frames or packets
  int64_t client_id = 0;   // edge: that the server gave
  uint16_t listener = 0;   // edge: port to which the server shall connect
  bool is_client = false;  // of a connection that the hostile peer opened
  bool is_mqtt5 = false;   // the client speaks MQTT 5
};

struct HostileMessage {
  Bytes bytes;
  bool has_memory = false;  // Local: the descriptor of hostile_memory() comes with it
};

// `kind` may be any number.
HostileMessage make_message(Protocol protocol, uint32_t kind, Conversation* conversation);
// Kinds by which a connection begins.
inline constexpr uint32_t kGreeting = 0;
// Kind of a message with a frame or a request, after the greeting.
inline constexpr uint32_t kFrame = 1;
// Edge: kinds of the handshake.
inline constexpr uint32_t kHostInfo = 2;
// Mqtt: the response to a subscription.
inline constexpr uint32_t kSubscribed = 2;
// Local: what a writer sends before the first frame.
inline constexpr uint32_t kMemory = 2, kCaps = 3;

// A message of TensorService with this frame, in protobuf.
std::string tensor_message(std::string_view frame);
// A block of shared memory as local streams have it.
int hostile_memory();

}  // namespace weir::fuzz
