// Tests the header of MQTT messages with bytes made from the table of docs/compatibility/io.md 7.5.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/wire/mqtt_header.hpp"

#include <gtest/gtest.h>

#include "core/wire/wire_test_support.hpp"
#include "says.hpp"

namespace weir::wire {
namespace mqtt_header_test {

using namespace test;

constexpr int64_t kBase = 1700000000000000000;  // 0x17979cfe362a0000
constexpr int64_t kSent = kBase + 1000;

MqttHeader example() {
  return {.sizes = {4, 3},
          .base_time_epoch = kBase,
          .sent_time_epoch = kSent,
          .duration = 33333333,  // 0x1fca055
          .dts = std::nullopt,
          .pts = 2000,
          .caps = "other/tensors"};
}

// What example() is by the table.
Bytes golden() {
  auto bytes = with_zeros("02 00 00 00 00 00 00 00 04 00 00 00 00 00 00 00 03", 1024);
  bytes = with_bytes(bytes, 136, "00 00 2a 36 fe 9c 97 17 e8 03 2a 36 fe 9c 97 17");
  bytes = with_bytes(bytes, 152, "55 a0 fc 01 00 00 00 00 ff ff ff ff ff ff ff ff d0 07");
  return with_bytes(bytes, 176, "6f 74 68 65 72 2f 74 65 6e 73 6f 72 73");
}

void expect_example(const Result<MqttHeader>& header) {
  ASSERT_TRUE(header) << header.error().message();
  const auto expected = example();
  EXPECT_EQ(header->sizes, expected.sizes);
  EXPECT_EQ(header->base_time_epoch, expected.base_time_epoch);
  EXPECT_EQ(header->sent_time_epoch, expected.sent_time_epoch);
  EXPECT_EQ(header->duration, expected.duration);
  EXPECT_EQ(header->dts, expected.dts);
  EXPECT_EQ(header->pts, expected.pts);
  EXPECT_EQ(header->caps, expected.caps);
}

TEST(MqttHeader, WritesTheBytesOfTheTable) {
  const auto bytes = write_mqtt_header(example());
  ASSERT_TRUE(bytes);
  EXPECT_EQ(*bytes, golden());
}

TEST(MqttHeader, ReadsTheBytesOfTheTable) {
  expect_example(parse_mqtt_header(golden()));
}

TEST(MqttHeader, ReadsThe32BitAlignments) {
  // Sizes are u32 at 4; the next fields begin at 68 on i386 and at 72 on arm32, caps at 108 and
  // 112.
  for (const auto& [alignment, times] :
       {std::pair(MqttAlignment::I386, size_t{68}), std::pair(MqttAlignment::Arm32, size_t{72})}) {
    auto bytes = with_zeros("02 00 00 00 04 00 00 00 03", 1024);
    const auto fields = golden();
    // Times and caps keep their distances.
    std::copy(fields.begin() + 136, fields.begin() + 688,
              bytes.begin() + static_cast<ptrdiff_t>(times));
    expect_example(parse_mqtt_header(bytes, alignment));
  }
}

TEST(MqttHeader, IgnoresPaddingAndUnusedSizes) {
  auto bytes = with_bytes(golden(), 4, "ff ff ff ff");
  for (size_t at = 8 + 2 * 8; at < 136; ++at) bytes[at] = std::byte{0xEE};
  for (size_t at = 688; at < 1024; ++at) bytes[at] = std::byte{0xEE};
  expect_example(parse_mqtt_header(bytes));
}

TEST(MqttHeader, HoldsSixteenMemoriesAnd511CharactersOfCaps) {
  MqttHeader header{.sizes = std::vector<uint64_t>(16, 1), .caps = std::string(511, 'c')};
  const auto bytes = write_mqtt_header(header);
  ASSERT_TRUE(bytes);
  const auto read = parse_mqtt_header(*bytes);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->sizes, header.sizes);
  EXPECT_EQ(read->caps, header.caps);
}

TEST(MqttHeader, RefusesToWriteMore) {
  EXPECT_REFUSED(write_mqtt_header({.sizes = std::vector<uint64_t>(17, 1)}), LIMIT_EXCEEDED,
                 "offered: 17 memories\n  needed: at most 16\n  fix: merge tensors");
  EXPECT_REFUSED(write_mqtt_header({.caps = std::string(512, 'c')}), LIMIT_EXCEEDED,
                 "caps are too long for an MQTT message\n  offered: 512 characters\n"
                 "  needed: at most 511");
  EXPECT_REFUSED(write_mqtt_header({.caps = std::string("a\0b", 3)}), OPTION_VALUE,
                 "caps contain a NUL\n  offered: \"a\\x00b\"");
}

TEST(MqttHeader, RefusesAnyShorterMessage) {
  const auto bytes = golden();
  for (size_t size = 0; size < bytes.size(); ++size)
    EXPECT_REFUSED(parse_mqtt_header(std::span(bytes).first(size)), PEER_MESSAGE_INVALID,
                   "is too short for its header\n  offered: " + std::to_string(size) +
                       " bytes\n  needed: at least 1024 bytes");
}

TEST(MqttHeader, RefusesMoreMemoriesAndCapsWithoutNul) {
  EXPECT_REFUSED(parse_mqtt_header(with_bytes(golden(), 0, "11")), PEER_MESSAGE_INVALID,
                 "has too many memories\n  offered: 17 memories\n  needed: at most 16");
  auto bytes = golden();
  for (size_t at = 176; at < 688; ++at) bytes[at] = std::byte{'c'};
  EXPECT_REFUSED(parse_mqtt_header(bytes), PEER_MESSAGE_INVALID,
                 "has caps without an end\n  offered: \"" + std::string(64, 'c') + "...\"");
}

TEST(MqttHeader, FindsTheMemories) {
  const auto payload = golden() + from_hex("01 02 03 04 78 79 7a");
  const auto memories = mqtt_memories(example(), payload);
  ASSERT_TRUE(memories);
  ASSERT_EQ(memories->size(), 2u);
  EXPECT_EQ(copy_of((*memories)[0]), from_hex("01 02 03 04"));
  EXPECT_EQ(copy_of((*memories)[1]), from_text("xyz"));
  // A sender with max-buffer-size may send more.
  EXPECT_TRUE(mqtt_memories(example(), payload + Bytes(5)));
}

TEST(MqttHeader, RefusesMemoriesThatAreNotThere) {
  const auto payload = golden() + from_hex("01 02 03 04 78 79");
  EXPECT_REFUSED(mqtt_memories(example(), payload), PEER_MESSAGE_INVALID,
                 "is shorter than its memories\n  offered: 2 bytes for memory 1\n"
                 "  needed: 3 bytes");
  EXPECT_REFUSED(mqtt_memories(example(), std::span(payload).first(10)), PEER_MESSAGE_INVALID,
                 "0 bytes for memory 0");
  // 4 + (2^64 - 1) is 3 with 64 bits.
  EXPECT_REFUSED(mqtt_memories({.sizes = {4, UINT64_MAX}}, payload), PEER_MESSAGE_INVALID,
                 "needed: 18446744073709551615 bytes");
}

TEST(MqttHeader, MovesTimesByTheDifferenceOfTheBases) {
  auto header = example();
  header.dts = 500;
  // The receiver began 300 ns before and after the sender.
  const auto earlier = times_of_receiver(header, kBase - 300);
  ASSERT_TRUE(earlier.has_value());
  EXPECT_EQ(earlier->pts, 2300u);
  EXPECT_EQ(earlier->dts, 800u);
  const auto later = times_of_receiver(header, kBase + 300);
  ASSERT_TRUE(later.has_value());
  EXPECT_EQ(later->pts, 1700u);
  EXPECT_EQ(later->dts, 200u);
}

TEST(MqttHeader, KeepsTimesThatAreNone) {
  auto header = example();
  header.pts = std::nullopt;
  const auto times = times_of_receiver(header, kBase);
  ASSERT_TRUE(times.has_value());
  EXPECT_EQ(times->pts, std::nullopt);
  EXPECT_EQ(times->dts, std::nullopt);
}

TEST(MqttHeader, DropsWhatWasSentBeforeTheReceiverBegan) {
  EXPECT_TRUE(times_of_receiver(example(), kSent).has_value());
  EXPECT_FALSE(times_of_receiver(example(), kSent + 1).has_value());
  auto header = example();
  header.pts = 100;
  EXPECT_FALSE(times_of_receiver(header, kBase + 101).has_value());
  EXPECT_TRUE(times_of_receiver(header, kBase + 100).has_value());
}

TEST(MqttHeader, DropsTimesBeyond64Bits) {
  auto header = example();
  header.pts = UINT64_MAX - 1;
  EXPECT_TRUE(times_of_receiver(header, kBase).has_value());
  EXPECT_FALSE(times_of_receiver(header, kBase - 1).has_value());
  header = example();
  header.base_time_epoch = INT64_MIN;
  EXPECT_FALSE(times_of_receiver(header, kBase).has_value());
  header.base_time_epoch = header.sent_time_epoch = INT64_MAX;
  const auto far = times_of_receiver(header, INT64_MIN);
  ASSERT_FALSE(far.has_value());
}

}  // namespace mqtt_header_test
}  // namespace weir::wire
