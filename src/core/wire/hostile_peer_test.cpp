// What a hostile or faulty peer can send, by the classes of docs/compatibility/edge-wire.md 10.6.
// Classes 6, 7, 8 and 10 are about sockets and elements, not about bytes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <algorithm>

#include "core/wire/edge_capability.hpp"
#include "core/wire/edge_conversation.hpp"
#include "core/wire/edge_message_reader.hpp"
#include "core/wire/edge_metadata.hpp"
#include "core/wire/mqtt_frame.hpp"
#include "core/wire/wire_test_support.hpp"
#include "says.hpp"

namespace weir::wire {
namespace hostile_peer_test {

using namespace test;

constexpr MessageLimits kLimits;
constexpr std::string_view kAllOnes = "ff ff ff ff ff ff ff ff";

std::vector<Bytes> golden_messages() {
  return {golden_capability(),
          golden_host_info(),
          golden_transfer_data(),
          golden_error(),
          golden_capability_of_0_2_2(),
          short_host_info(),
          short_host_info("02 00 00 05 00 00 dd ef")};
}

Result<size_t> feed_all(const Bytes& bytes) {
  return EdgeMessageReader(kLimits).feed(bytes);
}

// Class 1.
TEST(HostilePeer, MayCloseAfterAnyByte) {
  for (const auto& message : golden_messages())
    for (size_t size = 1; size < message.size(); ++size) {
      SCOPED_TRACE(size);
      EdgeMessageReader reader(kLimits);
      const auto taken = reader.feed(std::span(message).first(size));
      ASSERT_TRUE(taken) << taken.error().message();
      ASSERT_FALSE(reader.complete());
      EXPECT_REFUSED(reader.end(), PEER_MESSAGE_INVALID, "closed the connection in the middle");
    }
}

// Class 1.
TEST(HostilePeer, MaySendAnyByte) {
  // Each byte of the header with each bit flipped: an error, or a message within the limits.
  for (const auto& message : golden_messages())
    for (size_t at = 0; at < message.size(); ++at)
      for (int bit = 0; bit < 8; ++bit) {
        auto damaged = message;
        damaged[at] ^= static_cast<std::byte>(1 << bit);
        EdgeMessageReader reader(kLimits);
        const auto taken = reader.feed(damaged);
        if (!taken) {
          EXPECT_EQ(taken.error().code, Code::PEER_MESSAGE_INVALID);
          EXPECT_FALSE(taken.error().needed.empty());
        } else if (reader.complete()) {
          EXPECT_LE(reader.take().memories.size(), 256u);
        }
      }
}

// Class 2.
TEST(HostilePeer, MayDeclareMoreMemoriesThanTheTable) {
  EXPECT_REFUSED(feed_all(with_bytes(golden_transfer_data(), 24, "01 01 00 00")),
                 PEER_MESSAGE_INVALID,
                 "more memories than its header has sizes\n  offered: 257 memories\n"
                 "  needed: at most 256 in the 2088-byte form");
  EXPECT_REFUSED(feed_all(with_bytes(short_host_info(), 24, "ff ff ff ff")), PEER_MESSAGE_INVALID,
                 "offered: 4294967295 memories\n  needed: at most 16 in the 168-byte form");
  EXPECT_REFUSED(feed_all(with_bytes(golden_capability_of_0_2_2(), 16, "11 00 00 00")),
                 PEER_MESSAGE_INVALID, "offered: 17 memories\n  needed: at most 16");
}

// Class 2.
TEST(HostilePeer, MayDeclareSizesWhoseSumWraps) {
  // 2^63 + 2^63 = 0, and 4 + (2^64 - 1) = 3 with 64 bits.
  auto message = with_bytes(golden_transfer_data(), 32, "00 00 00 00 00 00 00 80");
  message = with_bytes(message, 40, "00 00 00 00 00 00 00 80");
  EXPECT_REFUSED(feed_all(message), PEER_MESSAGE_INVALID,
                 "offered: 9223372036854775808 bytes in memory 0 of 2\n"
                 "  needed: at most 67108864 bytes in all");
  EXPECT_REFUSED(feed_all(with_bytes(golden_transfer_data(), 40, kAllOnes)), PEER_MESSAGE_INVALID,
                 "offered: 18446744073709551615 bytes in memory 1 of 2");
  EXPECT_REFUSED(feed_all(with_bytes(golden_transfer_data(), 2080, kAllOnes)), PEER_MESSAGE_INVALID,
                 "the metadata of a message is too long");
}

// Class 2.
TEST(HostilePeer, MayDeclareSizesBeyondTheLimits) {
  const MessageLimits limits{.message_bytes = 100, .text_bytes = 20, .metadata_bytes = 10};
  const auto read = [&](const EdgeHeader& header) {
    const auto bytes = write_header(HeaderForm::Bytes2088, header);
    return read_header(HeaderForm::Bytes2088, *bytes, limits);
  };
  EXPECT_TRUE(read({.command = Command::TransferData, .sizes = {90}, .metadata_bytes = 10}));
  EXPECT_REFUSED(read({.command = Command::TransferData, .sizes = {91}, .metadata_bytes = 10}),
                 PEER_MESSAGE_INVALID, "offered: 91 bytes in memory 0 of 1\n  needed: at most 100");
  EXPECT_REFUSED(read({.command = Command::TransferData, .sizes = {60, 41}}), PEER_MESSAGE_INVALID,
                 "offered: 41 bytes in memory 1 of 2");
  EXPECT_REFUSED(read({.command = Command::TransferData, .metadata_bytes = 11}),
                 PEER_MESSAGE_INVALID, "offered: 11 bytes\n  needed: at most 10 bytes");
  EXPECT_TRUE(read({.command = Command::HostInfo, .sizes = {20}}));
  EXPECT_REFUSED(read({.command = Command::HostInfo, .sizes = {21}}), PEER_MESSAGE_INVALID,
                 "the text of HOST_INFO is too long\n  offered: 21 bytes\n  needed: at most 20");
}

// Class 2.
TEST(HostilePeer, GetsNoMemoryForSizesThatItDoesNotSend) {
  EdgeMessageReader reader(kLimits);
  ASSERT_TRUE(reader.feed(with_bytes(golden_transfer_data(), 32, "00 00 00 03 00 00 00 00")));
  // 48 MiB are declared.
  EXPECT_LE(reader.space().size(), size_t{64} << 10);
}

// Class 2 and 12.
TEST(HostilePeer, MayDeclareAMemoryOfNoBytes) {
  EXPECT_REFUSED(feed_all(with_bytes(golden_transfer_data(), 40, "00")), PEER_MESSAGE_INVALID,
                 "a message has a memory of 0 bytes\n  offered: memory 1");
}

// Class 3.
TEST(HostilePeer, MaySendATextWithoutNul) {
  auto message = golden_host_info();
  message.back() = std::byte{'9'};
  EdgeMessageReader reader(kLimits);
  ASSERT_TRUE(reader.feed(message));
  EXPECT_REFUSED(text_of_memory(reader.take().memories.at(0).bytes()), PEER_MESSAGE_INVALID,
                 "a text of a peer has no end\n  offered: \"127.0.0.1:41019\"");
}

// Class 3.
TEST(HostilePeer, MaySendNoTextOrSeveral) {
  for (const auto& golden : {golden_host_info(), golden_capability()}) {
    EXPECT_REFUSED(feed_all(with_bytes(golden, 24, "00")), PEER_MESSAGE_INVALID,
                   "does not have exactly one text\n  offered: 0 memories\n  needed: 1 memory");
    EXPECT_REFUSED(feed_all(with_bytes(with_bytes(golden, 24, "02"), 40, "01")),
                   PEER_MESSAGE_INVALID, "offered: 2 memories");
  }
}

// Class 3.
TEST(HostilePeer, MayAnnounceAnAddressThatIsNone) {
  const struct {
    std::string text;
    const char* says;
  } texts[] = {{"", "has no port"},
               {"localhost", "has no port"},
               {"localhost:", "has no usable port"},
               {"localhost:0", "has no usable port"},
               {"localhost:65536", "has no usable port"},
               {"localhost:99999999999999999999999", "has no usable port"},
               {"localhost:-1", "has no usable port"},
               {"localhost:+80", "has no usable port"},
               {"localhost:80 ", "has no usable port"},
               {"localhost:80:81", "has no usable port"},
               {"::1:80", "has no usable port"},
               {":80", "has no usable host"},
               {"a b:80", "has no usable host"},
               {"a/b:80", "has no usable host"},
               {"a\nb:80", "has no usable host"},
               {std::string(254, 'a') + ":80", "has no usable host"}};
  for (const auto& [text, says] : texts)
    EXPECT_REFUSED(parse_host_address(text), PEER_MESSAGE_INVALID, says);
}

// Class 3.
TEST(HostilePeer, CannotSendASecondHostInfo) {
  Conversation server(Side::ServerOnA);
  const auto first = server.next(Command::HostInfo);
  ASSERT_TRUE(first);
  EXPECT_EQ(*first, Action::ReadHostInfo);
  const auto second = server.next(Command::HostInfo);
  ASSERT_TRUE(second);
  EXPECT_EQ(*second, Action::Ignore);
}

// Class 3.
TEST(HostilePeer, MaySendCommandsInTheWrongState) {
  const auto unknown = static_cast<Command>(4);
  for (const auto side : {Side::ServerOnA, Side::Publisher})
    for (const auto command : {Command::TransferData, Command::Capability, unknown})
      EXPECT_REFUSED(Conversation(side).next(command), PEER_MESSAGE_INVALID,
                     "a peer does not complete the handshake\n  offered: " + to_string(command) +
                         "\n  needed: HOST_INFO or ERROR");
  for (const auto side : {Side::ClientOnA, Side::Subscriber})
    for (const auto command : {Command::TransferData, Command::HostInfo, unknown})
      EXPECT_REFUSED(Conversation(side).next(command), PEER_MESSAGE_INVALID,
                     "needed: CAPABILITY or ERROR");
}

// Class 4.
TEST(HostilePeer, MaySendMetadataThatIsNone) {
  const struct {
    const char* hex;
    const char* says;
  } blobs[] = {
      {"01", "is cut off\n  offered: 1 bytes"},
      {"01 00 00", "is cut off"},
      {"01 00 00 00", "is too short for its pairs"},
      {"ff ff ff ff 6b 00 76 00", "is too short for its pairs"},
      {"02 00 00 00 6b 00 76 00", "is too short for its pairs"},
      {"02 00 00 00 6b 00 76 76 76 76 76 76 00", "ends inside a pair\n  offered: pair 1"},
      {"01 00 00 00 6b 00 76 76", "ends inside a pair\n  offered: pair 0"},
      {"01 00 00 00 6b 6b 6b 6b", "ends inside a pair"},
      {"00 00 00 00 6b 00 76 00", "has more than its pairs\n  offered: 4 bytes"},
      {"01 00 00 00 6b 00 76 00 00", "has more than its pairs\n  offered: 1 bytes"},
      {"01 00 00 00 00 76 76 00", "has an empty key or value"},
      {"01 00 00 00 6b 6b 00 00", "has an empty key or value"},
      {"02 00 00 00 6b 00 76 00 6b 00 77 00", "has a key twice\n  offered: \"k\""},
      {"02 00 00 00 6b 00 76 00 4b 00 77 00", "has a key twice\n  offered: \"K\""},
  };
  for (const auto& [hex, says] : blobs) {
    SCOPED_TRACE(hex);
    EXPECT_REFUSED(EdgeMetadata::parse(from_hex(hex)), PEER_MESSAGE_INVALID, says);
  }
}

// Class 4.
TEST(HostilePeer, MaySendMetadataAtAnyAddress) {
  const auto blob = golden_metadata();
  for (size_t offset = 0; offset < 8; ++offset) {
    const auto bytes = Bytes(offset) + blob;
    const auto metadata = EdgeMetadata::parse(std::span(bytes).subspan(offset));
    ASSERT_TRUE(metadata);
    EXPECT_EQ(metadata->find("client_id"), "1051064743");
  }
}

// Class 4.
TEST(HostilePeer, MayCutMetadataAfterAnyByte) {
  const auto blob = golden_metadata();
  for (size_t size = 1; size < blob.size(); ++size) {
    SCOPED_TRACE(size);
    EXPECT_REFUSED(EdgeMetadata::parse(std::span(blob).first(size)), PEER_MESSAGE_INVALID,
                   "the metadata of a message ");
  }
}

// Class 5.
TEST(HostilePeer, CannotMakeTheServerConnectToAnotherMachine) {
  const std::vector<std::string> allowed{"camera-3"};
  const auto ask = [&](const char* host) {
    return callback_address({host, 80}, "192.0.2.7", allowed);
  };
  EXPECT_REFUSED(ask("192.0.2.8"), PEER_MESSAGE_INVALID,
                 "a client requests its answers at another machine\n"
                 "  offered: 192.0.2.8:80 from a connection of 192.0.2.7\n"
                 "  needed: the address of the connection\n"
                 "  fix: set host=192.0.2.7 on the client, or allow the other address with "
                 "allow=192.0.2.8");
  EXPECT_REFUSED(ask("169.254.169.254"), PEER_MESSAGE_INVALID, "another machine");
  EXPECT_REFUSED(ask("camera-4"), PEER_MESSAGE_INVALID, "another machine");
  EXPECT_REFUSED(ask("localhost.example"), PEER_MESSAGE_INVALID, "another machine");
  EXPECT_REFUSED(ask("1270.0.0.1"), PEER_MESSAGE_INVALID, "another machine");
  for (const char* own :
       {"192.0.2.7", "localhost", "LocalHost", "127.0.0.1", "127.9.8.7", "0.0.0.0"}) {
    const auto address = ask(own);
    ASSERT_TRUE(address) << own;
    EXPECT_EQ(*address, (HostAddress{"192.0.2.7", 80})) << own;
  }
  const auto listed = ask("camera-3");
  ASSERT_TRUE(listed);
  EXPECT_EQ(listed->host, "camera-3");
}

// Class 9; whether the caps parse is a question for GStreamer.
TEST(HostilePeer, MayAnnounceHalfOfItsCapsOrTooMuch) {
  for (const char* text : {"", "@", "@query_server_src_caps@A", "@query_server_sink_caps@A",
                           "@query_server_src_caps@A@query_server_sink_caps@",
                           "@query_server_src_caps@ @query_server_sink_caps@B",
                           "query_server_src_caps@A@query_server_sink_caps@B", "@edge_sink_caps@A"})
    EXPECT_REFUSED(parse_query_capability(text), PEER_MESSAGE_INVALID,
                   "a query server does not announce its caps");
  EXPECT_REFUSED(parse_publisher_capability(kCapabilityText), PEER_MESSAGE_INVALID,
                 "a peer is not a publisher");
  EXPECT_REFUSED(feed_all(with_bytes(golden_capability(), 32, "01 00 01 00")), PEER_MESSAGE_INVALID,
                 "the text of CAPABILITY is too long\n  offered: 65537 bytes");
}

// Class 11.
TEST(HostilePeer, MayPublishPayloadsThatAreNone) {
  EXPECT_REFUSED(parse_mqtt_frame(from_hex("da"), kLimits), PEER_MESSAGE_INVALID,
                 "is not a frame of edgesink\n  offered: 1 bytes");
  EXPECT_REFUSED(parse_mqtt_frame({}, kLimits), PEER_MESSAGE_INVALID, "offered: 0 bytes");
  EXPECT_REFUSED(parse_announcement(from_hex("00")), PEER_MESSAGE_INVALID, "has no port");
  EXPECT_REFUSED(parse_announcement(from_hex("61")), PEER_MESSAGE_INVALID, "has no end");
  const auto withdrawn = parse_announcement({});
  ASSERT_TRUE(withdrawn);
  EXPECT_FALSE(withdrawn->has_value());
}

// Class 11.
TEST(HostilePeer, MayPublishPayloadsOfAnyLength) {
  const auto golden = golden_mqtt_payload();
  for (size_t size = 0; size < golden.size(); ++size) {
    SCOPED_TRACE(size);
    const auto frame = parse_mqtt_frame(std::span(golden).first(size), kLimits);
    ASSERT_FALSE(frame);
    EXPECT_EQ(frame.error().code, Code::PEER_MESSAGE_INVALID);
  }
  EXPECT_REFUSED(parse_mqtt_frame(golden + Bytes(1), kLimits), PEER_MESSAGE_INVALID,
                 "does not have the length that its header declares\n  offered: 2101 bytes");
  EXPECT_REFUSED(parse_mqtt_frame(golden, {.message_bytes = 11}), PEER_MESSAGE_INVALID,
                 "is larger than allowed\n  offered: 2100 bytes\n  needed: at most 2099 bytes");
}

// Class 11.
TEST(HostilePeer, CannotBeReachedThroughATopicWithWildcards) {
  using namespace std::string_view_literals;
  for (const auto topic : {""sv, "+"sv, "a/#"sv, "a\0b"sv}) {
    EXPECT_REFUSED(announcement_topic("1", topic), OPTION_VALUE,
                   "topic cannot be part of an MQTT topic");
    EXPECT_REFUSED(announcement_filter(topic), OPTION_VALUE,
                   "needed: at least one character, and none of \"+#\\x00\"");
  }
  for (const auto id : {""sv, "+"sv, "a/b"sv, "#"sv, "\0"sv})
    EXPECT_REFUSED(announcement_topic(id, "t"), OPTION_VALUE, "id cannot be part of an MQTT topic");
}

// Class 12: what is sent has no duplicate keys and no padding but zeros. edge_header_test.cpp has
// memories of 0 bytes and too many memories.
TEST(HostilePeer, ReceivesNoDuplicateKeysAndNoBytesOfTheStack) {
  EdgeMetadata metadata;
  ASSERT_TRUE(metadata.set("k", "1"));
  ASSERT_TRUE(metadata.set("K", "2"));
  EXPECT_EQ(metadata.encode(), from_hex("01 00 00 00 4b 00 32 00"));
  for (const auto form : {HeaderForm::Bytes160, HeaderForm::Bytes168, HeaderForm::Bytes2088}) {
    const auto header =
        write_header(form, {.command = Command::TransferData, .client_id = -1, .sizes = {1}});
    ASSERT_TRUE(header);
    const auto& layout = get_layout(form);
    const auto is_zero = [](std::byte byte) { return byte == std::byte{0}; };
    EXPECT_TRUE(std::all_of(header->begin() + static_cast<ptrdiff_t>(layout.sizes_offset) + 8,
                            header->end(), is_zero));
    EXPECT_TRUE(std::all_of(header->begin() + static_cast<ptrdiff_t>(layout.count_offset) + 4,
                            header->begin() + static_cast<ptrdiff_t>(layout.sizes_offset),
                            is_zero));
  }
}

}  // namespace hostile_peer_test
}  // namespace weir::wire
