// Text of peers and files on terminals and in errors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "weir/printable_text.hpp"

#include <gtest/gtest.h>

#include "weir/result.hpp"

namespace weir {
namespace printable_text_test {

TEST(PrintableText, KeepsWhatPeopleWrite) {
  for (const char* text :
       {"", "person 93 %", "caf\xC3\xA9", "\xE7\x8C\xAB", "\xF0\x9F\x90\x88",
        "\xD8\xA3\xD9\x87\xD9\x84", "two\nlines\tand a tab", "\\x1b", "\xC2\xA0"})
    EXPECT_EQ(printable_text(text), text);
}

TEST(PrintableText, EscapesWhatATerminalActsOn) {
  EXPECT_EQ(printable_text("\x1b]0;title\x07"), "\\x1b]0;title\\x07");
  EXPECT_EQ(printable_text(std::string_view("a\0\r\b\x7F", 5)), "a\\x00\\x0d\\x08\\x7f");
  EXPECT_EQ(printable_text("\xC2\x9B"
                           "2J"),
            "\\xc2\\x9b2J");
  // The first and the last character that changes the direction of text, and their neighbours.
  EXPECT_EQ(printable_text("\xE2\x80\xAA\xE2\x80\xAE"), "\\xe2\\x80\\xaa\\xe2\\x80\\xae");
  EXPECT_EQ(printable_text("\xE2\x81\xA6\xE2\x81\xA9"), "\\xe2\\x81\\xa6\\xe2\\x81\\xa9");
  for (const char* text : {"\xE2\x80\xA9", "\xE2\x80\xAF", "\xE2\x81\xA5", "\xE2\x81\xAA"})
    EXPECT_EQ(printable_text(text), text);
}

TEST(PrintableText, EscapesBytesThatAreNotUtf8) {
  EXPECT_EQ(printable_text("a\xFFz\xC3"), "a\\xffz\\xc3");
  EXPECT_EQ(printable_text("\xED\xA0\x80\xE2\x82"), "\\xed\\xa0\\x80\\xe2\\x82");
}

TEST(PrintableText, DoesNotChangeWhenItIsEscapedAgain) {
  std::string all;
  for (int c = 0; c < 256; ++c) all.push_back(static_cast<char>(c));
  const std::string once = printable_text(all);
  EXPECT_EQ(printable_text(once), once);
}

TEST(PrintableText, IsThatOfTheMessageOfAnError) {
  const Error error{.code = Code::SPEC_MISMATCH,
                    .what = "a\x1b[2J",
                    .offered = "\xFF",
                    .needed = "caf\xC3\xA9",
                    .difference = "one\ntwo",
                    .fix = "\xE2\x80\xAE"};
  EXPECT_EQ(error.message(),
            "WEIR-2001: a\\x1b[2J\n  offered: \\xff\n  needed: caf\xC3\xA9\n"
            "  first difference: one\ntwo\n  fix: \\xe2\\x80\\xae");
}

}  // namespace printable_text_test
}  // namespace weir
