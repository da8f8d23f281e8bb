// Tests headers of nnstreamer-edge messages with the bytes of docs/compatibility/edge-wire.md 10.7.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/wire/edge_header.hpp"

#include <gtest/gtest.h>

#include "core/wire/wire_test_support.hpp"
#include "says.hpp"

namespace weir::wire {
namespace edge_header_test {

using namespace test;

constexpr MessageLimits kLimits;

TEST(EdgeHeader, WritesTheCapabilityOfThePage) {
  const auto message =
      text_message(HeaderForm::Bytes2088, Command::Capability, kClientId, kCapabilityText);
  ASSERT_TRUE(message) << message.error().message();
  EXPECT_EQ(*message, golden_capability());
}

TEST(EdgeHeader, WritesTheHostInfoOfThePage) {
  const auto message =
      text_message(HeaderForm::Bytes2088, Command::HostInfo, kClientId, "127.0.0.1:4101");
  ASSERT_TRUE(message);
  EXPECT_EQ(*message, golden_host_info());
}

TEST(EdgeHeader, WritesTheTransferDataOfThePage) {
  const auto header = write_header(HeaderForm::Bytes2088, {.command = Command::TransferData,
                                                           .client_id = kClientId,
                                                           .sizes = {4, 3},
                                                           .metadata_bytes = 25});
  ASSERT_TRUE(header);
  EXPECT_EQ(*header, start_of(golden_transfer_data(), 2088));
}

TEST(EdgeHeader, WritesTheErrorOfThePage) {
  EXPECT_EQ(error_message(HeaderForm::Bytes2088), golden_error());
}

TEST(EdgeHeader, WritesTheCapabilityOf0_2_2) {
  const auto message =
      text_message(HeaderForm::Bytes160, Command::Capability, 0x42546461, kCapabilityText);
  ASSERT_TRUE(message);
  EXPECT_EQ(*message, golden_capability_of_0_2_2());
}

TEST(EdgeHeader, WritesTheHostInfoOf0_2_4) {
  const auto message = text_message(HeaderForm::Bytes168, Command::HostInfo, 7, "h:1");
  ASSERT_TRUE(message);
  EXPECT_EQ(*message, short_host_info());
}

TEST(EdgeHeader, PlacesTheMetadataSizeOfEachForm) {
  // 10.2: at 2080, 160 and 152.
  const struct {
    HeaderForm form;
    size_t offset, bytes;
  } forms[] = {{HeaderForm::Bytes2088, 2080, 2088},
               {HeaderForm::Bytes168, 160, 168},
               {HeaderForm::Bytes160, 152, 160}};
  for (const auto& [form, offset, bytes] : forms) {
    const auto header =
        write_header(form, {.command = Command::TransferData, .metadata_bytes = 0x0102});
    ASSERT_TRUE(header);
    ASSERT_EQ(header->size(), bytes);
    EXPECT_EQ((*header)[offset], std::byte{2});
    EXPECT_EQ((*header)[offset + 1], std::byte{1});
  }
}

TEST(EdgeHeader, ReadsTheTransferDataOfThePage) {
  const auto header = read_header(HeaderForm::Bytes2088, golden_transfer_data(), kLimits);
  ASSERT_TRUE(header) << header.error().message();
  EXPECT_EQ(header->command, Command::TransferData);
  EXPECT_EQ(header->client_id, kClientId);
  EXPECT_EQ(header->sizes, (std::vector<uint64_t>{4, 3}));
  EXPECT_EQ(header->metadata_bytes, 25u);
}

TEST(EdgeHeader, ReadsTheCapabilityOf0_2_2) {
  const auto header = read_header(HeaderForm::Bytes160, golden_capability_of_0_2_2(), kLimits);
  ASSERT_TRUE(header) << header.error().message();
  EXPECT_EQ(header->command, Command::Capability);
  EXPECT_EQ(header->client_id, 0x42546461);
  EXPECT_EQ(header->sizes, (std::vector<uint64_t>{50}));
}

TEST(EdgeHeader, IgnoresPaddingAndUnusedSizes) {
  auto message = with_bytes(golden_transfer_data(), 28, "ff ff ff ff");
  for (size_t at = 32 + 2 * 8; at < 2080; ++at) message[at] = std::byte{0xEE};
  const auto header = read_header(HeaderForm::Bytes2088, message, kLimits);
  ASSERT_TRUE(header) << header.error().message();
  EXPECT_EQ(header->sizes, (std::vector<uint64_t>{4, 3}));
}

TEST(EdgeHeader, ReadsAsManyMemoriesAsTheTableHas) {
  // 10.2: 256 memories leave a sender of 0.2.6.
  auto message = with_bytes(golden_transfer_data(), 24, "00 01 00 00");
  for (size_t i = 0; i < 256; ++i)
    message = with_bytes(std::move(message), 32 + 8 * i, "01 00 00 00 00 00 00 00");
  const auto header = read_header(HeaderForm::Bytes2088, message, kLimits);
  ASSERT_TRUE(header) << header.error().message();
  EXPECT_EQ(header->sizes.size(), 256u);
}

TEST(EdgeHeader, GreetsBothNewerForms) {
  const auto greeting = greeting_for_both_forms(kClientId, kCapabilityText);
  ASSERT_TRUE(greeting);
  // A client of 0.2.6 reads the message of the page, whose unused sizes it ignores.
  auto expected = golden_capability();
  const auto text = from_text(kCapabilityText);
  std::copy(text.begin(), text.end(), expected.begin() + 168);
  EXPECT_EQ(*greeting, expected);
  // A client of 0.2.4 reads the first 168 bytes and the text at once.
  const auto header = read_header(HeaderForm::Bytes168, *greeting, kLimits);
  ASSERT_TRUE(header) << header.error().message();
  ASSERT_EQ(header->sizes, (std::vector<uint64_t>{50}));
  EXPECT_EQ(header->metadata_bytes, 0u);
  EXPECT_EQ(copy_of(std::span(*greeting).subspan(168, 50)), text + from_hex("00"));
}

TEST(EdgeHeader, KeepsTheMetadataSizeOutOfALongGreeting) {
  // From 168 to the metadata size at 2080 there are 1912 bytes: 1911 characters and a NUL.
  const auto fits = greeting_for_both_forms(1, std::string(1911, 'a'));
  ASSERT_TRUE(fits);
  EXPECT_EQ(copy_of(std::span(*fits).subspan(2077, 11)),
            from_hex("61 61 00 00 00 00 00 00 00 00 00"));
  const auto header = read_header(HeaderForm::Bytes2088, *fits, kLimits);
  ASSERT_TRUE(header);
  EXPECT_EQ(header->metadata_bytes, 0u);
  const auto too_long = greeting_for_both_forms(1, std::string(1912, 'a'));
  ASSERT_TRUE(too_long);
  EXPECT_EQ(copy_of(std::span(*too_long).subspan(168, 1920)), Bytes(1920));
}

TEST(EdgeHeader, NamesCommands) {
  EXPECT_EQ(to_string(Command::TransferData), "TRANSFER_DATA");
  EXPECT_EQ(to_string(static_cast<Command>(9)), "command 9");
}

TEST(EdgeHeader, ReportsWhatIsCutOff) {
  EXPECT_REFUSED(
      read_header(HeaderForm::Bytes168, start_of(short_host_info(), 167), kLimits),
      PEER_MESSAGE_INVALID,
      "a message header is cut off\n  offered: 167 bytes\n  needed: 168 bytes (168-byte form)");
}

TEST(EdgeHeader, ReportsAnotherMagicAndVersion) {
  EXPECT_REFUSED(
      read_header(HeaderForm::Bytes2088, with_bytes(golden_error(), 0, "fe ed fe ed"), kLimits),
      PEER_MESSAGE_INVALID, "does not begin with the magic number");
  EXPECT_REFUSED(
      read_header(HeaderForm::Bytes2088, with_bytes(golden_error(), 14, "de ef"), kLimits),
      PEER_MESSAGE_INVALID, "offered: 61406 in the top 16 bits\n  needed: 61405 (0xefdd)");
}

TEST(EdgeHeader, ReportsTheAlignmentOfI386) {
  // The sizes are at 28, since nothing is between them and the number of memories.
  const auto message = with_zeros(
      "ed fe ed fe 02 00 00 00 02 00 00 06 00 00 dd ef 07 00 00 00 00 00 00 00 01 00 00 00 "
      "04 00 00 00 00 00 00 00",
      2084, "68 3a 31 00");
  EXPECT_REFUSED(read_header(HeaderForm::Bytes2088, message, kLimits), PEER_MESSAGE_INVALID,
                 "the alignment of 32-bit x86");
}

TEST(EdgeHeader, RefusesToSendWhatPeersCannotReceive) {
  EXPECT_REFUSED(
      write_header(HeaderForm::Bytes2088,
                   {.command = Command::TransferData, .sizes = std::vector<uint64_t>(256, 1)}),
      LIMIT_EXCEEDED, "offered: 256 memories\n  needed: at most 255 in the 2088-byte form");
  EXPECT_TRUE(write_header(HeaderForm::Bytes2088, {.command = Command::TransferData,
                                                   .sizes = std::vector<uint64_t>(255, 1)}));
  for (const auto form : {HeaderForm::Bytes168, HeaderForm::Bytes160}) {
    EXPECT_REFUSED(write_header(form, {.command = Command::TransferData,
                                       .sizes = std::vector<uint64_t>(16, 1)}),
                   LIMIT_EXCEEDED, "offered: 16 memories\n  needed: at most 15");
    EXPECT_TRUE(write_header(
        form, {.command = Command::TransferData, .sizes = std::vector<uint64_t>(15, 1)}));
  }
  EXPECT_REFUSED(
      write_header(HeaderForm::Bytes2088, {.command = Command::TransferData, .sizes = {1, 0}}),
      FRAME_SIZE, "a memory of 0 bytes, which peers cannot receive\n  offered: memory 1");
}

TEST(EdgeHeader, RefusesTextsThatCannotBeSent) {
  using namespace std::string_view_literals;
  EXPECT_REFUSED(text_message(HeaderForm::Bytes2088, Command::HostInfo, 1, "h\0:1"sv), OPTION_VALUE,
                 "a text for HOST_INFO contains a NUL\n  offered: \"h\\x00:1\"");
  EXPECT_REFUSED(
      text_message(HeaderForm::Bytes2088, Command::Capability, 1, std::string(65536, 'a')),
      LIMIT_EXCEEDED, "offered: 65537 bytes with its NUL\n  needed: at most 65536 bytes");
  EXPECT_TRUE(text_message(HeaderForm::Bytes2088, Command::Capability, 1, std::string(65535, 'a')));
}

}  // namespace edge_header_test
}  // namespace weir::wire
