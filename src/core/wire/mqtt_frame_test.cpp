// Tests frames and addresses of MQTT with the bytes of docs/compatibility/edge-wire.md 10.5, 10.7.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/wire/mqtt_frame.hpp"

#include <gtest/gtest.h>

#include "core/wire/edge_metadata.hpp"
#include "core/wire/wire_test_support.hpp"
#include "says.hpp"

namespace weir::wire {
namespace mqtt_frame_test {

using namespace test;

constexpr MessageLimits kLimits;

// One memory "xyz" without metadata, in the two older forms of 10.5.
Bytes payload_of_0_2_4() {
  return with_zeros("da ed da ed 00 00 00 00 02 00 00 04 00 00 dd ef 01 00 00 00 00 00 00 00 03",
                    160, "78 79 7a");
}
Bytes payload_of_0_2_3() {
  return with_zeros("da ed da ed 01 00 00 00 03 00 00 00 00 00 00 00", 144, "78 79 7a");
}

TEST(MqttFrame, WritesThatOfThePage) {
  const uint64_t sizes[] = {4};
  const auto header = write_mqtt_frame_header(MqttForm::Bytes2080, sizes, 16);
  ASSERT_TRUE(header) << header.error().message();
  EXPECT_EQ(*header, start_of(golden_mqtt_payload(), 2080));
}

TEST(MqttFrame, WritesTheOlderForms) {
  const uint64_t sizes[] = {3};
  const auto of_0_2_4 = write_mqtt_frame_header(MqttForm::Bytes160, sizes, 0);
  const auto of_0_2_3 = write_mqtt_frame_header(MqttForm::Bytes144, sizes, 0);
  ASSERT_TRUE(of_0_2_4 && of_0_2_3);
  EXPECT_EQ(*of_0_2_4, start_of(payload_of_0_2_4(), 160));
  EXPECT_EQ(*of_0_2_3, start_of(payload_of_0_2_3(), 144));
}

TEST(MqttFrame, ReadsThatOfThePage) {
  const auto payload = golden_mqtt_payload();
  const auto frame = parse_mqtt_frame(payload, kLimits);
  ASSERT_TRUE(frame) << frame.error().message();
  EXPECT_EQ(frame->form, MqttForm::Bytes2080);
  ASSERT_EQ(frame->memories.size(), 1u);
  EXPECT_EQ(copy_of(frame->memories[0]), from_hex("01 02 03 04"));
  const auto metadata = EdgeMetadata::parse(frame->metadata);
  ASSERT_TRUE(metadata);
  EXPECT_EQ(metadata->pairs(), (std::vector<EdgeMetadata::Pair>{{"k2", "v2"}, {"k1", "v1"}}));
}

TEST(MqttFrame, ReadsTheOlderForms) {
  const struct {
    Bytes payload;
    MqttForm form;
  } payloads[] = {{payload_of_0_2_4(), MqttForm::Bytes160},
                  {payload_of_0_2_3(), MqttForm::Bytes144}};
  for (const auto& [payload, form] : payloads) {
    const auto frame = parse_mqtt_frame(payload, kLimits);
    ASSERT_TRUE(frame) << frame.error().message();
    EXPECT_EQ(frame->form, form);
    ASSERT_EQ(frame->memories.size(), 1u);
    EXPECT_EQ(copy_of(frame->memories[0]), from_text("xyz"));
    EXPECT_TRUE(frame->metadata.empty());
  }
}

TEST(MqttFrame, IgnoresBytesOfTheStackInPadding) {
  auto payload = with_bytes(golden_mqtt_payload(), 4, "ad de be 7f");
  payload = with_bytes(payload, 20, "01 02 03 04");
  for (size_t at = 24 + 8; at < 2072; ++at) payload[at] = std::byte{0x7F};
  const auto frame = parse_mqtt_frame(payload, kLimits);
  ASSERT_TRUE(frame) << frame.error().message();
  EXPECT_EQ(frame->memories.size(), 1u);
}

TEST(MqttFrame, RefusesWhatReceiversCannotRead) {
  EXPECT_REFUSED(write_mqtt_frame_header(MqttForm::Bytes2080, {}, 0), FRAME_SIZE,
                 "a frame without memories cannot be published");
  const uint64_t empty[] = {1, 0};
  EXPECT_REFUSED(write_mqtt_frame_header(MqttForm::Bytes2080, empty, 0), FRAME_SIZE,
                 "a memory of 0 bytes");
  const std::vector<uint64_t> many(256, 1);
  EXPECT_REFUSED(write_mqtt_frame_header(MqttForm::Bytes2080, many, 0), LIMIT_EXCEEDED,
                 "at most 255");
  EXPECT_REFUSED(write_mqtt_frame_header(MqttForm::Bytes144, std::span(many).first(16), 0),
                 LIMIT_EXCEEDED, "at most 15");
}

TEST(MqttFrame, RefusesSizesThatAreNotThePayload) {
  for (const char* size : {"05", "03", "00 00 00 00 00 00 00 80", "ff ff ff ff ff ff ff ff"})
    EXPECT_REFUSED(parse_mqtt_frame(with_bytes(golden_mqtt_payload(), 24, size), kLimits),
                   PEER_MESSAGE_INVALID,
                   "does not have the length that its header declares\n  offered: 2100 bytes\n"
                   "  needed: the header (2080, 160 or 144 bytes), its memories and metadata");
  // 4 + (2^64 - 4) + 20 is 20 with 64 bits.
  auto wraps = with_bytes(golden_mqtt_payload(), 16, "02");
  wraps = with_bytes(wraps, 32, "fc ff ff ff ff ff ff ff");
  wraps = with_bytes(wraps, 2072, "14");
  EXPECT_REFUSED(parse_mqtt_frame(wraps, kLimits), PEER_MESSAGE_INVALID,
                 "does not have the length");
}

TEST(MqttFrame, RefusesAnotherMagicManyMemoriesAndLongMetadata) {
  EXPECT_REFUSED(parse_mqtt_frame(with_bytes(golden_mqtt_payload(), 0, "db"), kLimits),
                 PEER_MESSAGE_INVALID, "without the magic number 0xeddaedda");
  EXPECT_REFUSED(parse_mqtt_frame(with_bytes(golden_mqtt_payload(), 16, "01 01"), kLimits),
                 PEER_MESSAGE_INVALID, "does not have the length");
  EXPECT_REFUSED(parse_mqtt_frame(golden_mqtt_payload(), {.metadata_bytes = 15}),
                 PEER_MESSAGE_INVALID, "is too long\n  offered: 16 bytes\n  needed: at most 15");
}

TEST(MqttFrame, NamesTheTopicsOfThePage) {
  const auto topic = announcement_topic("7", "objects/fast");
  const auto filter = announcement_filter("objects/fast");
  ASSERT_TRUE(topic && filter);
  EXPECT_EQ(*topic, "edge/inference/device-7/objects/fast/");
  EXPECT_EQ(*filter, "edge/inference/+/objects/fast/#");
}

TEST(MqttFrame, AnnouncesTheAddressOfThePage) {
  const auto payload = from_hex("31 32 37 2e 30 2e 30 2e 31 3a 34 31 30 31 00");
  EXPECT_EQ(announcement_payload({"127.0.0.1", 4101}), payload);
  const auto address = parse_announcement(payload);
  ASSERT_TRUE(address && address->has_value());
  EXPECT_EQ(address->value(), (HostAddress{"127.0.0.1", 4101}));
}

TEST(MqttFrame, RefusesAnAddressThatIsCut) {
  const auto payload = announcement_payload({"localhost", 3000});
  for (size_t size = 1; size < payload.size(); ++size)
    EXPECT_REFUSED(parse_announcement(std::span(payload).first(size)), PEER_MESSAGE_INVALID,
                   "a text of a peer has no end");
}

}  // namespace mqtt_frame_test
}  // namespace weir::wire
