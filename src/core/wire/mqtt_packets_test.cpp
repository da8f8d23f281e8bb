// Packets of a broker that libmosquitto must not see. Their bytes are those of MQTT 5, chapters 2
// and 3.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/wire/mqtt_packets.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "core/wire/wire_test_support.hpp"
#include "says.hpp"

namespace weir::wire {
namespace mqtt_packets_test {

using test::Bytes;
using test::from_hex;
using test::from_text;
using test::start_of;
using test::operator+;

Status check(const Bytes& bytes) {
  Bytes passed;
  auto status = MqttPacketFilter().feed(bytes, &passed);
  // What is passed on is a part of it, and whole if it is accepted.
  EXPECT_TRUE(passed.size() <= bytes.size() &&
              std::equal(passed.begin(), passed.end(), bytes.begin()));
  if (status) {
    EXPECT_EQ(passed, bytes);
  }
  return status;
}
// A PUBLISH of QoS 0 to the topic "t" with these properties and the payload "x".
Bytes publish(const Bytes& properties) {
  const auto number = [](size_t value) {
    Bytes out;
    do {
      out.push_back(static_cast<std::byte>(value % 128 + (value > 127 ? 128 : 0)));
      value /= 128;
    } while (value > 0);
    return out;
  };
  const Bytes body = from_hex("00 01 74") + number(properties.size()) + properties + from_text("x");
  return from_hex("30") + number(body.size()) + body;
}

const char* const kPackets[] = {
    "20 03 00 00 00",                                // CONNACK
    "20 02 00 01",                                   // of a broker of MQTT 3
    "20 0b 00 00 08 21 00 10 22 00 0a 25 01",        // with Receive Maximum and others
    "30 04 00 01 74 00",                             // PUBLISH of QoS 0 to "t"
    "30 05 00 01 74 00 78",                          // with a payload
    "32 06 00 01 74 00 07 00",                       // of QoS 1
    "34 0d 00 01 74 00 07 07 26 00 01 61 00 01 62",  // of QoS 2 with a user property
    "30 0a 00 01 74 05 02 00 00 00 05 78",           // with Message Expiry Interval
    "40 02 00 07",                                   // PUBACK
    "50 03 00 07 10",                                // PUBREC with a reason
    "62 04 00 07 00 00",                             // PUBREL with properties
    "70 0a 00 07 00 06 1f 00 03 62 61 64",           // PUBCOMP with a Reason String
    "90 04 00 07 00 01",                             // SUBACK
    "b0 04 00 07 00 00",                             // UNSUBACK
    "d0 00",                                         // PINGRESP
    "e0 00",                                         // DISCONNECT
    "e0 01 8b",                                      // with a reason
    "e0 02 8b 00",                                   // with properties
    "f0 0c 18 0a 15 00 01 61 16 00 03 78 79 7a",     // AUTH
};

TEST(MqttPacketFilter, AcceptsThePacketsOfTheStandard) {
  for (const char* packet : kPackets) EXPECT_TRUE(check(from_hex(packet))) << packet;
  EXPECT_TRUE(
      check(publish(from_hex("01 01 03 00 01 61 08 00 01 62 09 00 01 63 0b 80 01 23 00 01"))));
  EXPECT_TRUE(
      check(from_hex("20 39 00 00 36 11 00 00 00 01 12 00 01 61 13 00 0a 15 00 01 61"
                     "16 00 01 61 1a 00 01 61 1c 00 01 61 1f 00 01 61 21 00 01 22 00 01"
                     "24 01 25 01 26 00 01 61 00 01 62 27 00 00 01 00")));
}

TEST(MqttPacketFilter, AcceptsThemInPiecesOfAnySize) {
  Bytes all;
  for (const char* packet : kPackets) all = std::move(all) + from_hex(packet);
  all = std::move(all) + publish(Bytes(0)) + from_hex("30 84 80 01 00 01 74 00") + Bytes(16384);
  all = std::move(all) + from_hex("d0 00");
  for (const size_t size : {size_t{1}, size_t{2}, size_t{3}, size_t{7}, all.size()}) {
    MqttPacketFilter filter;
    Bytes passed;
    for (size_t at = 0; at < all.size(); at += size)
      ASSERT_TRUE(filter.feed(std::span(all).subspan(at, std::min(size, all.size() - at)), &passed))
          << at;
    EXPECT_EQ(passed, all);
    EXPECT_REFUSED(filter.feed(from_hex("10 00"), &passed), PEER_MESSAGE_INVALID,
                   "a packet of type 1");
    EXPECT_EQ(passed, all);
  }
}

TEST(MqttPacketFilter, RejectsPropertiesThatTheStandardDoesNotHave) {
  for (int id = 0; id < 256; ++id) {
    Bytes property = from_hex("00 00 00 00 00");
    property[0] = static_cast<std::byte>(id);
    const auto status = check(publish(property));
    const std::string name = "a property with the number " + std::to_string(id) + "\n";
    const bool is_known = status || status.error().message().find(name) == std::string::npos;
    constexpr std::string_view kIds[] = {"1",  "2",  "3",  "8",  "9",  "11", "17", "18", "19",
                                         "21", "22", "23", "24", "25", "26", "28", "31", "33",
                                         "34", "35", "36", "37", "38", "39", "40", "41", "42"};
    const bool is_of_standard =
        std::find(std::begin(kIds), std::end(kIds), std::to_string(id)) != std::end(kIds);
    EXPECT_EQ(is_known, is_of_standard) << id;
  }
  const auto status = check(publish(from_hex("7f")));
  EXPECT_REFUSED(status, PEER_MESSAGE_INVALID, "a property with the number 127");
  EXPECT_SAYS(status.error().message(), "fix: protocol=4, which is MQTT 3.1.1");
  // In the last place, and before the rest of the packet has come.
  EXPECT_FALSE(check(publish(from_hex("26 00 01 61 00 01 62 00"))));
  const Bytes unknown = publish(from_hex("7f"));
  EXPECT_FALSE(check(start_of(unknown, unknown.size() - 1)));
  for (const char* packet : {"20 04 00 00 01 7f", "40 05 00 07 00 01 7f", "90 05 00 07 01 7f 01",
                             "e0 03 00 01 7f", "f0 03 00 01 7f", "b0 05 00 07 01 7f 00"})
    EXPECT_FALSE(check(from_hex(packet))) << packet;
}

TEST(MqttPacketFilter, RejectsSizesThatDoNotFit) {
  for (const char* packet :
       {"30 04 00 05 74 00", "30 04 00 01 74 01", "30 03 00 01 74", "30 02 00 00", "90 02 00 07",
        "20 04 00 00 05 22", "32 05 00 01 74 00 07", "20 05 00 00 02 22 00"})
    EXPECT_REFUSED(check(from_hex(packet)), PEER_MESSAGE_INVALID, "propert");
  for (const char* properties : {"26 00 01 61 00 02 62", "26 00 03 61", "03 00", "0b 80", "02 00"})
    EXPECT_REFUSED(check(publish(from_hex(properties))), PEER_MESSAGE_INVALID,
                   "a property that exceeds the properties of its packet");
  EXPECT_REFUSED(check(from_hex("30 ff ff ff ff")), PEER_MESSAGE_INVALID,
                 "a length of more than four bytes");
  EXPECT_REFUSED(check(from_hex("30 ff ff ff 7f 00 00 ff ff ff ff")), PEER_MESSAGE_INVALID,
                 "a length of more than four bytes");
}

// 16 MiB of them took 200 MB as objects.
TEST(MqttPacketFilter, AMessageWithTooManyPropertiesLosesThem) {
  const auto with = [](size_t pairs) {
    Bytes properties;
    for (size_t i = 0; i < pairs; ++i)
      properties = std::move(properties) + from_hex("26 00 00 00 00");
    return publish(properties);
  };
  EXPECT_TRUE(check(with(kMaxMqttPropertyBytes / 5)));
  const Bytes all = with(kMaxMqttPropertyBytes / 5 + 1) + from_hex("d0 00");
  for (const size_t size : {size_t{1}, size_t{1000}, all.size()}) {
    MqttPacketFilter filter;
    Bytes passed;
    for (size_t at = 0; at < all.size(); at += size)
      ASSERT_TRUE(
          filter.feed(std::span(all).subspan(at, std::min(size, all.size() - at)), &passed));
    EXPECT_EQ(passed, publish({}) + from_hex("d0 00"));
    EXPECT_EQ(filter.stripped(), 1u);
  }
}

// mosquitto 2.0.21 answers a message above its message_size_limit with 0x95.
TEST(MqttPacketFilter, AnUnknownReasonOfARefusalIsReplaced) {
  struct Case {
    const char *packet, *passed;
  };
  for (const auto& [packet, passed] : {
           Case{"40 03 00 07 95", "40 03 00 07 80"},
           Case{"50 03 00 07 95", "50 03 00 07 80"},
           Case{"40 04 00 07 95 00", "40 04 00 07 80 00"},
           Case{"40 0a 00 07 ff 06 1f 00 03 62 61 64", "40 0a 00 07 80 06 1f 00 03 62 61 64"},
       }) {
    MqttPacketFilter filter;
    Bytes out;
    for (const std::byte byte : from_hex(packet)) EXPECT_TRUE(filter.feed({&byte, 1}, &out));
    EXPECT_EQ(out, from_hex(passed)) << packet;
    EXPECT_EQ(filter.replaced(), 1u) << packet;
  }
  for (const char* packet : {"40 03 00 07 80", "40 03 00 07 99", "40 03 00 07 00", "70 03 00 07 92",
                             "50 03 00 07 10", "e0 01 95", "90 04 00 07 00 95"})
    EXPECT_TRUE(check(from_hex(packet))) << packet;
}

TEST(MqttPacketFilter, RejectsOtherPacketsWithTooManyProperties) {
  EXPECT_REFUSED(check(from_hex("20 ff ff 7f 00 00 fa ff 7f")), PEER_MESSAGE_INVALID,
                 "2097146 bytes of properties");
}

TEST(MqttPacketFilter, StaysAtTheFirstError) {
  MqttPacketFilter filter;
  Bytes passed;
  EXPECT_FALSE(filter.feed(publish(from_hex("7f")), &passed));
  EXPECT_FALSE(filter.feed(from_hex("d0 00"), &passed));
  EXPECT_EQ(passed, Bytes());
}

}  // namespace mqtt_packets_test
}  // namespace weir::wire
