// Fuzz target: messages of MQTT: the header of mqttsink, frames of edgesink, addresses of servers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/wire/mqtt_header.hpp"

#include <vector>

#include "core/wire/edge_metadata.hpp"
#include "core/wire/mqtt_frame.hpp"
#include "fuzz_input.hpp"

namespace {

using namespace weir;
using namespace weir::wire;
using fuzz::require;

constexpr MessageLimits kLimits{.message_bytes = 1 << 16, .metadata_bytes = 512};

// Whether the parts follow each other from `begin` to the end of `payload` or before it.
size_t end_of_parts(const std::vector<std::span<const std::byte>>& parts,
                    std::span<const std::byte> payload, size_t begin) {
  for (const auto part : parts) {
    require(part.data() == payload.data() + begin, "memories follow each other");
    begin += part.size();
  }
  require(begin <= payload.size(), "memories lie inside the payload");
  return begin;
}

void require_same(const MqttHeader& a, const MqttHeader& b) {
  require(a.sizes == b.sizes && a.base_time_epoch == b.base_time_epoch &&
              a.sent_time_epoch == b.sent_time_epoch && a.duration == b.duration &&
              a.dts == b.dts && a.pts == b.pts && a.caps == b.caps,
          "a header that is written is read again");
}

void check_header(std::span<const std::byte> payload, MqttAlignment alignment,
                  int64_t own_base_epoch) {
  const auto header = parse_mqtt_header(payload, alignment);
  if (!header) {
    require(header.error().code == Code::PEER_MESSAGE_INVALID, "bad bytes are a peer's fault");
    return;
  }
  require(header->sizes.size() <= kMaxMqttMemories, "a header has at most 16 sizes");
  require(header->caps.size() < kMaxMqttCapsBytes, "caps end within 512 bytes");
  const auto bytes = write_mqtt_header(*header);
  require(bytes && bytes->size() == kMqttHeaderBytes, "what is read can be written");
  const auto again = parse_mqtt_header(*bytes);
  require(static_cast<bool>(again), "what is written can be read");
  require_same(*header, *again);
  if (const auto memories = mqtt_memories(*header, payload))
    (void)end_of_parts(*memories, payload, kMqttHeaderBytes);
  const auto times = times_of_receiver(*header, own_base_epoch);
  require(!times || header->sent_time_epoch >= own_base_epoch, "old messages are dropped");
  require(!times || times->pts.has_value() == header->pts.has_value(), "a PTS stays one");
}

void read_frame(std::span<const std::byte> payload) {
  const auto frame = parse_mqtt_frame(payload, kLimits);
  if (!frame) {
    require(frame.error().code == Code::PEER_MESSAGE_INVALID, "bad bytes are a peer's fault");
    return;
  }
  std::vector<uint64_t> sizes;
  size_t bytes = frame->metadata.size();
  for (const auto memory : frame->memories) {
    require(!memory.empty(), "a memory has bytes");
    sizes.push_back(memory.size());
    bytes += memory.size();
  }
  require(!sizes.empty() && bytes < payload.size(), "a frame has memories and a header");
  const size_t end = end_of_parts(frame->memories, payload, payload.size() - bytes);
  require(end + frame->metadata.size() == payload.size(), "the metadata ends the payload");
  (void)EdgeMetadata::parse(frame->metadata);
  if (const auto header = write_mqtt_frame_header(frame->form, sizes, frame->metadata.size()))
    require(header->size() == payload.size() - bytes, "the form has its header");
}

void read_announcement(std::span<const std::byte> payload) {
  const auto address = parse_announcement(payload);
  if (!address || !*address) return;
  const auto again = parse_announcement(announcement_payload(**address));
  require(again && *again == *address, "an address that is written is read again");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::FuzzInput input(data, size);
  const auto alignment = static_cast<MqttAlignment>(input.below(3));
  const auto own_base_epoch = input.take<int64_t>();
  const std::vector<std::byte> payload(input.rest().begin(), input.rest().end());
  check_header(payload, alignment, own_base_epoch);
  read_frame(payload);
  read_announcement(payload);
  return 0;
}
