// Tests of the position of a mistake, and of values that are not allowed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "core/text/error_text.hpp"

namespace weir {
namespace error_text_test {

TEST(Place, IsMarkedBelowTheText) {
  EXPECT_EQ(place_in("abc", 1), "at character 2:\n    abc\n     ^");
  EXPECT_EQ(place_in("abc", 0), "at character 1:\n    abc\n    ^");
}

TEST(Place, AfterTheTextIsItsEnd) {
  EXPECT_EQ(place_in("abc", 3), "at the end:\n    abc\n       ^");
  EXPECT_EQ(place_in("abc", 77), "at the end:\n    abc\n       ^");
  EXPECT_EQ(place_in("", 0), "it is empty");
}

TEST(Place, CountsCharactersAndNotBytes) {
  EXPECT_EQ(place_in("ü=ü!", 5), "at character 4:\n    ü=ü!\n       ^");
}

TEST(Place, ATextOfSeveralLinesIsShownInOne) {
  EXPECT_EQ(place_in("a\nb\tc\r\nd", 7), "at character 8:\n    a b c  d\n           ^");
}

TEST(Place, ALongTextIsShortenedAroundThePlace) {
  const std::string text = std::string(200, 'a') + "X" + std::string(200, 'b');
  EXPECT_EQ(place_in(text, 200), "at character 201:\n    ... " + std::string(50, 'a') + "X" +
                                     std::string(39, 'b') + " ...\n" + std::string(58, ' ') + "^");
  EXPECT_EQ(place_in(text, 3), "at character 4:\n    " + std::string(43, 'a') + " ...\n       ^");
  EXPECT_EQ(place_in(text, 400), "at character 401:\n    ... " + std::string(50, 'b') + "b\n" +
                                     std::string(58, ' ') + "^");
}

// Every position of a text with characters of one to four bytes: no character is cut, and the caret
// is below its character.
TEST(Place, SplitsNoCharacter) {
  std::string text;
  while (text.size() < 300) text += "aü€😀";
  for (size_t at = 0; at < text.size(); ++at) {
    if ((static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U) continue;
    const std::string message = place_in(text, at);
    const size_t begin = message.find('\n') + 1;
    const std::string line = message.substr(begin, message.find('\n', begin) - begin);
    const auto caret = message.size() - 1 - message.rfind('\n') - 1;
    size_t byte = 0;
    for (size_t column = 0; column < caret; ++column) do
        ++byte;
      while ((static_cast<unsigned char>(line[byte]) & 0xC0U) == 0x80U);
    EXPECT_EQ(line[byte], text[at]) << message;
    EXPECT_NE(static_cast<unsigned char>(line[line.starts_with("    ... ") ? 8 : 4]) & 0xC0U, 0x80U)
        << message;
  }
}

const std::vector<std::string> kFits{"auto", "stretch", "letterbox"};

TEST(Choice, ListsTheChoicesAndTheNearestOne) {
  EXPECT_EQ(not_one_of("no such fit", "leterbox", kFits).message(),
            "WEIR-1004: no such fit\n  offered: leterbox\n"
            "  needed: one of: auto, stretch, letterbox\n"
            "  first difference: did you mean letterbox?");
}

TEST(Choice, SuggestsNothingIfNoChoiceIsNear) {
  EXPECT_EQ(not_one_of("no such fit", "crop", kFits).difference, "");
  EXPECT_EQ(not_one_of("no such fit", "crop", {}).needed, "one of: none");
}

}  // namespace error_text_test
}  // namespace weir
