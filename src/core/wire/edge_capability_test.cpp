// Tests metadata, texts and the order of nnstreamer-edge messages. hostile_peer_test.cpp has what
// is refused.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/wire/edge_capability.hpp"

#include <gtest/gtest.h>

#include "core/wire/edge_conversation.hpp"
#include "core/wire/edge_metadata.hpp"
#include "core/wire/peer_error.hpp"
#include "core/wire/wire_test_support.hpp"
#include "says.hpp"

namespace weir::wire {
namespace edge_capability_test {

using namespace test;
using namespace std::string_view_literals;

TEST(EdgeMetadata, WritesAndReadsThatOfThePage) {
  EdgeMetadata metadata;
  EXPECT_TRUE(metadata.encode().empty());
  ASSERT_TRUE(metadata.set("client_id", "1051064743"));
  EXPECT_EQ(metadata.encode(), golden_metadata());
  const auto read = EdgeMetadata::parse(golden_metadata());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->pairs(), metadata.pairs());
}

TEST(EdgeMetadata, PutsTheLastPairFirst) {
  // 10.7: k1=v1, then k2=v2.
  EdgeMetadata metadata;
  ASSERT_TRUE(metadata.set("k1", "v1"));
  ASSERT_TRUE(metadata.set("k2", "v2"));
  EXPECT_EQ(metadata.encode(), from_hex("02 00 00 00 6b 32 00 76 32 00 6b 31 00 76 31 00"));
}

TEST(EdgeMetadata, FindsKeysOfAnyCase) {
  const auto metadata = EdgeMetadata::parse(golden_metadata());
  ASSERT_TRUE(metadata);
  EXPECT_EQ(metadata->find("CLIENT_ID"), "1051064743");
  EXPECT_EQ(metadata->find("client"), std::nullopt);
}

TEST(EdgeMetadata, HasNoPairsWithoutBytesOrWithTheCountZero) {
  for (const auto& bytes : {Bytes{}, from_hex("00 00 00 00")}) {
    const auto metadata = EdgeMetadata::parse(bytes);
    ASSERT_TRUE(metadata);
    EXPECT_TRUE(metadata->pairs().empty());
  }
}

TEST(EdgeMetadata, RefusesTextsThatReceiversWouldDrop) {
  EdgeMetadata metadata;
  EXPECT_REFUSED(metadata.set("", "v"), OPTION_VALUE,
                 "a key or value of metadata cannot be sent\n  offered: \"\" = \"v\"");
  EXPECT_REFUSED(metadata.set("k", ""), OPTION_VALUE, "at least one character in each");
  EXPECT_REFUSED(metadata.set("k\0"sv, "v"), OPTION_VALUE, "none of them NUL");
  EXPECT_REFUSED(metadata.set("k", "\0v"sv), OPTION_VALUE, "none of them NUL");
  EXPECT_TRUE(metadata.pairs().empty());
}

TEST(EdgeTexts, WriteAndReadTheCapsOfAQuery) {
  const auto text = query_capability_text({"A", "B"});
  ASSERT_TRUE(text);
  EXPECT_EQ(*text, kCapabilityText);
  const auto caps = parse_query_capability(kCapabilityText);
  ASSERT_TRUE(caps);
  EXPECT_EQ(caps->source_caps, "A");
  EXPECT_EQ(caps->sink_caps, "B");
}

TEST(EdgeTexts, TakeTheFirstOfRepeatedKeysInAnyOrder) {
  const auto caps = parse_query_capability(
      "@query_server_sink_caps@B@other@C@query_server_src_caps@A@query_server_sink_caps@D");
  ASSERT_TRUE(caps);
  EXPECT_EQ(caps->source_caps, "A");
  EXPECT_EQ(caps->sink_caps, "B");
}

TEST(EdgeTexts, TakeNoValueForAKey) {
  // The odd pieces are keys: here `query_server_src_caps` is a value.
  EXPECT_REFUSED(parse_query_capability("@x@query_server_src_caps@A@query_server_sink_caps@B@"),
                 PEER_MESSAGE_INVALID, "needed: @query_server_src_caps@ and the caps");
}

TEST(EdgeTexts, WriteAndReadTheCapsOfAPublisher) {
  const auto text = publisher_capability_text("video/x-raw, width=(int)4");
  ASSERT_TRUE(text);
  EXPECT_EQ(*text, "@edge_sink_caps@video/x-raw, width=(int)4");
  const auto caps = parse_publisher_capability(*text);
  ASSERT_TRUE(caps);
  EXPECT_EQ(*caps, "video/x-raw, width=(int)4");
  const auto unknown = parse_publisher_capability("@edge_sink_caps@");
  ASSERT_TRUE(unknown);
  EXPECT_EQ(*unknown, "");
}

TEST(EdgeTexts, RefuseCapsThatNoPeerCouldSeparate) {
  EXPECT_REFUSED(query_capability_text({"a", "b@c"}), OPTION_VALUE,
                 "caps cannot be sent to a peer\n  offered: \"b@c\"\n"
                 "  needed: caps without @ and NUL");
  EXPECT_REFUSED(publisher_capability_text("a\0"sv), OPTION_VALUE, "\"a\\x00\"");
}

TEST(EdgeTexts, ReadAddresses) {
  const auto address = parse_host_address("127.0.0.1:4101");
  ASSERT_TRUE(address);
  EXPECT_EQ(*address, (HostAddress{"127.0.0.1", 4101}));
  EXPECT_EQ(address->to_string(), "127.0.0.1:4101");
  for (const char* text : {"localhost:1", "a-b_c.example:65535"})
    EXPECT_TRUE(parse_host_address(text)) << text;
}

TEST(EdgeTexts, EndAtTheFirstNul) {
  const auto text = text_of_memory(from_hex("61 00 62 00"));
  ASSERT_TRUE(text);
  EXPECT_EQ(text->size(), 1u);
  EXPECT_REFUSED(text_of_memory({}), PEER_MESSAGE_INVALID, "a text of a peer has no end");
}

TEST(PeerError, QuotesBytesOfAPeerAsPrintableText) {
  EXPECT_EQ(quoted_text("a\x1b[31m\xff\n"), "\"a\\x1b[31m\\xff\\x0a\"");
  EXPECT_EQ(quoted_text(std::string(65, 'a')), "\"" + std::string(64, 'a') + "...\"");
  EXPECT_EQ(quoted_text(std::string(64, 'a')), "\"" + std::string(64, 'a') + "\"");
}

TEST(PeerError, NamesAFix) {
  EXPECT_SAYS(peer_error("w", "o", "n").message(),
              "WEIR-6004: w\n  offered: o\n  needed: n\n  fix: check the address");
  EXPECT_EQ(peer_error("w", "o", "n", "f").fix, "f");
}

// The actions for these commands in turn.
std::vector<Action> actions(Side side, std::initializer_list<Command> commands) {
  Conversation conversation(side);
  std::vector<Action> out;
  for (const auto command : commands) {
    const auto action = conversation.next(command);
    EXPECT_TRUE(action) << to_string(command);
    if (action) out.push_back(*action);
  }
  return out;
}

TEST(Conversation, OfAQueryHasTwoConnections) {
  using enum Command;
  EXPECT_EQ(
      actions(Side::ServerOnA, {HostInfo, TransferData, TransferData, Error}),
      (std::vector{Action::ReadHostInfo, Action::ReadFrame, Action::ReadFrame, Action::Close}));
  EXPECT_EQ(actions(Side::ClientOnA, {Capability, Error}),
            (std::vector{Action::ReadCapability, Action::Close}));
  EXPECT_EQ(actions(Side::ClientOnB, {TransferData, Error}),
            (std::vector{Action::ReadFrame, Action::Close}));
  EXPECT_EQ(actions(Side::ServerOnB, {Error}), (std::vector{Action::Close}));
}

TEST(Conversation, OfAPublisherHasOneConnection) {
  using enum Command;
  EXPECT_EQ(actions(Side::Publisher, {HostInfo, Error}),
            (std::vector{Action::ReadHostInfo, Action::Close}));
  EXPECT_EQ(actions(Side::Subscriber, {Capability, TransferData, Error}),
            (std::vector{Action::ReadCapability, Action::ReadFrame, Action::Close}));
}

TEST(Conversation, EndsWithAnErrorInTheHandshake) {
  for (const auto side : {Side::ServerOnA, Side::ClientOnA, Side::Publisher, Side::Subscriber})
    EXPECT_EQ(actions(side, {Command::Error}), (std::vector{Action::Close}));
}

TEST(Conversation, IgnoresWhatMeansNothingAfterTheHandshake) {
  using enum Command;
  const auto unknown = static_cast<Command>(77);
  EXPECT_EQ(actions(Side::ClientOnA, {Capability, TransferData, Capability, unknown}),
            (std::vector{Action::ReadCapability, Action::Ignore, Action::Ignore, Action::Ignore}));
  EXPECT_EQ(actions(Side::Publisher, {HostInfo, TransferData, HostInfo}),
            (std::vector{Action::ReadHostInfo, Action::Ignore, Action::Ignore}));
  EXPECT_EQ(actions(Side::ServerOnB, {TransferData, HostInfo}),
            (std::vector{Action::Ignore, Action::Ignore}));
}

TEST(Conversation, KnowsWhenTheHandshakeIsComplete) {
  Conversation server(Side::ServerOnA);
  EXPECT_TRUE(server.is_in_handshake());
  EXPECT_FALSE(server.next(Command::TransferData));
  EXPECT_TRUE(server.is_in_handshake());
  EXPECT_TRUE(server.next(Command::HostInfo));
  EXPECT_FALSE(server.is_in_handshake());
  EXPECT_FALSE(Conversation(Side::ClientOnB).is_in_handshake());
}

}  // namespace edge_capability_test
}  // namespace weir::wire
