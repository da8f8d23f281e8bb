// Tests which form of the header the first bytes of a peer show.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/wire/header_form.hpp"

#include <gtest/gtest.h>

#include "core/wire/wire_test_support.hpp"
#include "says.hpp"

namespace weir::wire {
namespace header_form_test {

using namespace test;

constexpr std::string_view kVersion0_2_5 = "02 00 00 05 00 00 dd ef";

// The start of a message of 2088 bytes of 0.2.5 with one memory of `size` bytes.
Bytes long_message_of_0_2_5(std::string_view size, size_t bytes) {
  return with_zeros("ed fe ed fe 03 00 00 00" + std::string(kVersion0_2_5) +
                        "07 00 00 00 00 00 00 00 01 00 00 00 00 00 00 00" + std::string(size),
                    bytes);
}

// The same of the form of 168 bytes with an empty text.
Bytes empty_text_of_0_2_5() {
  return long_message_of_0_2_5("01", 169);
}

std::optional<HeaderForm> form_of(std::span<const std::byte> start) {
  const auto decision = recognise_form(start);
  EXPECT_TRUE(decision);
  return decision ? decision->form : std::nullopt;
}

size_t needed_by(std::span<const std::byte> start) {
  const auto decision = recognise_form(start);
  EXPECT_TRUE(decision && !decision->form);
  return decision ? decision->needed : 0;
}

TEST(HeaderForm, NeedsSixteenBytes) {
  const auto message = golden_host_info();
  for (size_t size = 0; size < 16; ++size) {
    SCOPED_TRACE(size);
    EXPECT_EQ(needed_by(std::span(message).first(size)), 16u);
  }
}

TEST(HeaderForm, IsDecidedByTheVersionKey) {
  EXPECT_EQ(form_of(start_of(golden_host_info(), 16)), HeaderForm::Bytes2088);
  EXPECT_EQ(form_of(start_of(short_host_info(), 16)), HeaderForm::Bytes168);
  EXPECT_EQ(form_of(start_of(golden_capability_of_0_2_2(), 16)), HeaderForm::Bytes160);
}

TEST(HeaderForm, ComparesMajorThenMinorThenMicro) {
  // Bits 24-35 are micro, 12-23 major, 0-11 minor.
  const struct {
    const char* key;
    HeaderForm form;
  } versions[] = {{"02 00 00 03 00 00 dd ef", HeaderForm::Bytes168},    // 0.2.3
                  {"01 00 00 ff 0f 00 dd ef", HeaderForm::Bytes168},    // 0.1.4095
                  {"02 00 00 07 00 00 dd ef", HeaderForm::Bytes2088},   // 0.2.7
                  {"03 00 00 00 00 00 dd ef", HeaderForm::Bytes2088},   // 0.3.0
                  {"00 10 00 00 00 00 dd ef", HeaderForm::Bytes2088}};  // 1.0.0
  for (const auto& [key, form] : versions) {
    SCOPED_TRACE(key);
    EXPECT_EQ(form_of(with_bytes(golden_error(), 8, key)), form);
  }
}

TEST(HeaderForm, IsDecidedByTheTextOf0_2_5) {
  const auto short_form = short_host_info(kVersion0_2_5);
  EXPECT_EQ(needed_by(std::span(short_form).first(16)), 169u);
  EXPECT_EQ(needed_by(std::span(short_form).first(168)), 169u);
  EXPECT_EQ(form_of(std::span(short_form).first(169)), HeaderForm::Bytes168);
  EXPECT_EQ(form_of(long_message_of_0_2_5("04", 169)), HeaderForm::Bytes2088);
}

TEST(HeaderForm, IsDecidedBySilenceForAnEmptyTextOf0_2_5) {
  const auto short_form = empty_text_of_0_2_5();
  EXPECT_EQ(needed_by(short_form), 170u);
  EXPECT_EQ(form_after_silence(short_form), HeaderForm::Bytes168);
  EXPECT_EQ(form_of(long_message_of_0_2_5("01", 170)), HeaderForm::Bytes2088);
}

TEST(HeaderForm, IsDecidedBySilenceForAnErrorOf0_2_5) {
  const auto short_form = with_zeros("ed fe ed fe 00 00 00 00" + std::string(kVersion0_2_5), 168);
  EXPECT_EQ(needed_by(short_form), 169u);
  EXPECT_EQ(form_after_silence(short_form), HeaderForm::Bytes168);
  EXPECT_EQ(form_of(short_form + Bytes(1)), HeaderForm::Bytes2088);
}

TEST(HeaderForm, IsNotDecidedBySilenceInTheMiddleOfAMessage) {
  const auto message = long_message_of_0_2_5("04", 168);
  for (size_t size = 0; size <= message.size(); ++size) {
    SCOPED_TRACE(size);
    EXPECT_EQ(form_after_silence(std::span(message).first(size)), std::nullopt);
  }
  EXPECT_EQ(form_after_silence(from_text("GET / HTTP/1.1\r\n")), std::nullopt);
}

TEST(HeaderForm, ReportsWhatIsNoMessage) {
  EXPECT_REFUSED(recognise_form(from_text("GET / HTTP/1.1\r\n")), PEER_MESSAGE_INVALID,
                 "a connection does not begin with an nnstreamer-edge message\n"
                 "  offered: the bytes \"GET \"");
  EXPECT_REFUSED(recognise_form(from_hex("fe ed fe ed")), PEER_MESSAGE_INVALID,
                 "offered: the bytes \"\\xfe\\xed\\xfe\\xed\"\n"
                 "  needed: the magic number 0xfeedfeed, little-endian");
}

}  // namespace header_form_test
}  // namespace weir::wire
