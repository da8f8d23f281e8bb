// Tests the reader of nnstreamer-edge messages: bytes in any pieces, cut and damaged messages.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/wire/edge_message_reader.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/wire/edge_metadata.hpp"
#include "core/wire/wire_test_support.hpp"
#include "says.hpp"

namespace weir::wire {
namespace edge_message_reader_test {

using namespace test;

constexpr MessageLimits kLimits;
constexpr std::string_view kVersion0_2_5 = "02 00 00 05 00 00 dd ef";

// A CAPABILITY, HOST_INFO or frame of each form, first of a connection.
std::vector<Bytes> one_of_each_form() {
  return {golden_transfer_data(), golden_capability(), golden_capability_of_0_2_2(),
          short_host_info(), short_host_info(kVersion0_2_5)};
}

// Feeds all bytes in pieces of `size`; returns false after an error.
bool feed_in_pieces(const Bytes& bytes, size_t size, EdgeMessageReader* reader) {
  for (size_t at = 0; at < bytes.size(); at += size) {
    const auto piece = std::span(bytes).subspan(at, std::min(size, bytes.size() - at));
    const auto taken = reader->feed(piece);
    if (!taken || *taken != piece.size()) return false;
  }
  return true;
}

TEST(EdgeMessageReader, ReadsTheTransferDataOfThePage) {
  EdgeMessageReader reader(kLimits);
  ASSERT_TRUE(feed_in_pieces(golden_transfer_data(), 4096, &reader));
  ASSERT_TRUE(reader.complete());
  EXPECT_EQ(reader.form(), HeaderForm::Bytes2088);
  const auto message = reader.take();
  EXPECT_EQ(message.command, Command::TransferData);
  EXPECT_EQ(message.client_id, kClientId);
  ASSERT_EQ(message.memories.size(), 2u);
  EXPECT_EQ(copy_of(message.memories[0].bytes()), from_hex("01 02 03 04"));
  EXPECT_EQ(copy_of(message.memories[1].bytes()), from_text("xyz"));
  EXPECT_EQ(copy_of(message.metadata.bytes()), golden_metadata());
  EXPECT_TRUE(reader.end());
}

TEST(EdgeMessageReader, ReadsMessagesInPiecesOfAnySize) {
  for (const auto& bytes : one_of_each_form())
    for (const size_t size : {1, 2, 3, 7, 16, 160, 168, 169, 170, 2087, 2088, 2089}) {
      SCOPED_TRACE(size);
      EdgeMessageReader whole(kLimits), pieces(kLimits);
      ASSERT_TRUE(feed_in_pieces(bytes, bytes.size(), &whole));
      ASSERT_TRUE(feed_in_pieces(bytes, size, &pieces));
      ASSERT_TRUE(whole.complete() && pieces.complete());
      EXPECT_EQ(whole.form(), pieces.form());
      const auto expected = whole.take(), message = pieces.take();
      EXPECT_EQ(message.command, expected.command);
      EXPECT_EQ(message.client_id, expected.client_id);
      ASSERT_EQ(message.memories.size(), expected.memories.size());
      for (size_t i = 0; i < message.memories.size(); ++i)
        EXPECT_EQ(copy_of(message.memories[i].bytes()), copy_of(expected.memories[i].bytes()));
    }
}

TEST(EdgeMessageReader, RecognisesTheFormOfThePeer) {
  const HeaderForm forms[] = {HeaderForm::Bytes2088, HeaderForm::Bytes2088, HeaderForm::Bytes160,
                              HeaderForm::Bytes168, HeaderForm::Bytes168};
  const auto messages = one_of_each_form();
  for (size_t i = 0; i < messages.size(); ++i) {
    EdgeMessageReader reader(kLimits);
    ASSERT_TRUE(feed_in_pieces(messages[i], 1, &reader));
    EXPECT_EQ(reader.form(), forms[i]);
  }
}

TEST(EdgeMessageReader, StopsAtTheEndOfAMessage) {
  EdgeMessageReader reader(kLimits);
  const auto first = golden_host_info();
  const auto both = first + golden_transfer_data();
  const auto taken = reader.feed(both);
  ASSERT_TRUE(taken);
  EXPECT_EQ(*taken, first.size());
  EXPECT_TRUE(reader.space().empty());
  EXPECT_EQ(reader.take().command, Command::HostInfo);
  const auto rest = reader.feed(std::span(both).subspan(*taken));
  ASSERT_TRUE(rest);
  EXPECT_EQ(*rest, golden_transfer_data().size());
  ASSERT_TRUE(reader.complete());
  EXPECT_EQ(reader.take().memories.size(), 2u);
}

TEST(EdgeMessageReader, ReadsLaterMessagesInTheFormOfTheFirst) {
  EdgeMessageReader reader(kLimits);
  ASSERT_TRUE(feed_in_pieces(short_host_info(kVersion0_2_5), 1, &reader));
  (void)reader.take();
  // A frame of 0.2.5 whose memory begins with 0 does not show its form.
  const auto frame = with_zeros("ed fe ed fe 01 00 00 00" + std::string(kVersion0_2_5) +
                                    "07 00 00 00 00 00 00 00 01 00 00 00 00 00 00 00 02",
                                168, "00 05");
  ASSERT_TRUE(feed_in_pieces(frame, 1, &reader));
  ASSERT_TRUE(reader.complete());
  EXPECT_EQ(copy_of(reader.take().memories.at(0).bytes()), from_hex("00 05"));
}

TEST(EdgeMessageReader, ReadsTheGivenForm) {
  // What a client of 0.2.4 reads of the greeting for both forms.
  EdgeMessageReader reader(kLimits, HeaderForm::Bytes168);
  const auto greeting = greeting_for_both_forms(kClientId, kCapabilityText);
  ASSERT_TRUE(greeting);
  ASSERT_TRUE(reader.feed(*greeting));
  ASSERT_TRUE(reader.complete());
  EXPECT_EQ(copy_of(reader.take().memories.at(0).bytes()),
            from_text(kCapabilityText) + from_hex("00"));
}

TEST(EdgeMessageReader, DecidesAnEmptyTextOf0_2_5BySilence) {
  const auto message = with_zeros("ed fe ed fe 03 00 00 00" + std::string(kVersion0_2_5) +
                                      "07 00 00 00 00 00 00 00 01 00 00 00 00 00 00 00 01",
                                  169);
  EdgeMessageReader reader(kLimits);
  ASSERT_TRUE(feed_in_pieces(message, 1, &reader));
  EXPECT_FALSE(reader.complete());
  ASSERT_TRUE(reader.silence());
  EXPECT_EQ(reader.form(), HeaderForm::Bytes168);
  ASSERT_TRUE(reader.complete());
  EXPECT_EQ(copy_of(reader.take().memories.at(0).bytes()), from_hex("00"));

  // The same start, and then the rest of a header of 2088 bytes.
  EdgeMessageReader longer(kLimits);
  auto rest = message;
  rest.resize(2088 + 1);
  ASSERT_TRUE(feed_in_pieces(rest, 1, &longer));
  EXPECT_EQ(longer.form(), HeaderForm::Bytes2088);
  EXPECT_TRUE(longer.complete());
}

TEST(EdgeMessageReader, IsNotChangedBySilenceAtOtherTimes) {
  const auto message = golden_transfer_data();
  EdgeMessageReader reader(kLimits);
  for (const std::byte byte : message) {
    ASSERT_TRUE(reader.silence());
    ASSERT_TRUE(reader.feed({&byte, 1}));
  }
  EXPECT_TRUE(reader.complete());
  EXPECT_TRUE(reader.silence());
  EXPECT_EQ(reader.take().memories.size(), 2u);
}

TEST(EdgeMessageReader, CompletesAnErrorOf0_2_5AtTheEnd) {
  EdgeMessageReader reader(kLimits);
  ASSERT_TRUE(reader.feed(with_zeros("ed fe ed fe 00 00 00 00" + std::string(kVersion0_2_5), 168)));
  EXPECT_FALSE(reader.complete());
  EXPECT_TRUE(reader.end());
  ASSERT_TRUE(reader.complete());
  EXPECT_EQ(reader.take().command, Command::Error);
}

// A frame of one memory of `size` bytes, without its memory.
Bytes header_of_frame(uint64_t size) {
  const auto header =
      write_header(HeaderForm::Bytes2088, {.command = Command::TransferData, .sizes = {size}});
  EXPECT_TRUE(header);
  return header ? *header : Bytes{};
}

TEST(EdgeMessageReader, AllocatesAsBytesArrive) {
  constexpr size_t kSize = size_t{60} << 20;
  EdgeMessageReader reader(kLimits);
  ASSERT_TRUE(reader.feed(header_of_frame(kSize)));
  // The room is never larger than what has arrived, from 64 KiB on.
  size_t arrived = 0;
  while (!reader.complete()) {
    const size_t room = reader.space().size();
    ASSERT_GT(room, 0u);
    ASSERT_LE(room, std::max(arrived, size_t{64} << 10));
    ASSERT_TRUE(reader.received(room));
    arrived += room;
  }
  EXPECT_EQ(arrived, kSize);
  EXPECT_EQ(reader.take().memories.at(0).size, kSize);
  // A peer that has sent this much gets the memory at once.
  ASSERT_TRUE(reader.feed(header_of_frame(kSize)));
  EXPECT_EQ(reader.space().size(), kSize);
}

TEST(EdgeMessageReader, KeepsBytesWhenItsMemoryGrows) {
  Bytes memory(300000);
  for (size_t i = 0; i < memory.size(); ++i) memory[i] = static_cast<std::byte>(i * 7 + i / 251);
  EdgeMessageReader reader(kLimits);
  ASSERT_TRUE(feed_in_pieces(header_of_frame(memory.size()) + memory, 10007, &reader));
  ASSERT_TRUE(reader.complete());
  EXPECT_EQ(copy_of(reader.take().memories.at(0).bytes()), memory);
}

TEST(EdgeMessageReader, ReportsWhereAPeerEnded) {
  EdgeMessageReader reader(kLimits);
  ASSERT_TRUE(reader.feed(start_of(golden_transfer_data(), 2088 + 2)));
  EXPECT_REFUSED(reader.end(), PEER_MESSAGE_INVALID,
                 "the peer closed the connection in the middle of a message\n"
                 "  offered: 2 of 4 bytes of memory 0 of TRANSFER_DATA");
  EdgeMessageReader metadata(kLimits);
  ASSERT_TRUE(metadata.feed(start_of(golden_transfer_data(), 2088 + 7 + 24)));
  EXPECT_REFUSED(metadata.end(), PEER_MESSAGE_INVALID, "24 of 25 bytes of the metadata");
  EdgeMessageReader header(kLimits);
  ASSERT_TRUE(header.feed(start_of(golden_transfer_data(), 5)));
  EXPECT_REFUSED(header.end(), PEER_MESSAGE_INVALID, "the first 5 bytes of a header");
}

TEST(EdgeMessageReader, RepeatsItsError) {
  EdgeMessageReader reader(kLimits);
  EXPECT_REFUSED(reader.feed(from_text("SSH-2.0-OpenSSH_9.2")), PEER_MESSAGE_INVALID,
                 "does not begin with an nnstreamer-edge message\n  offered: the bytes \"SSH-\"");
  EXPECT_TRUE(reader.space().empty());
  EXPECT_REFUSED(reader.feed(golden_error()), PEER_MESSAGE_INVALID, "SSH-");
  EXPECT_REFUSED(reader.silence(), PEER_MESSAGE_INVALID, "SSH-");
  EXPECT_REFUSED(reader.end(), PEER_MESSAGE_INVALID, "SSH-");
  EXPECT_FALSE(reader.complete());
}

TEST(EdgeMessageReader, RefusesMoreBytesThanItsSpace) {
  EdgeMessageReader reader(kLimits);
  EXPECT_REFUSED(reader.received(17), INTERNAL, "more bytes were received than there was space");
}

}  // namespace edge_message_reader_test
}  // namespace weir::wire
