// Quotes for the shell, tried with a shell; what reads the same is not quoted.
// src/gstcpp tries the quotes for GStreamer with its parser.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/shell_quote.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <random>
#include <string>

namespace weir {
namespace shell_quote_test {

// What `sh` passes to a program as arguments, each with a | after it.
std::string read_by_shell(const std::string& words) {
  const std::string command = "printf '%s|' " + words;
  std::string out;
  std::FILE* const pipe = popen(command.c_str(), "r");
  std::array<char, 4096> part{};
  while (const size_t bytes = std::fread(part.data(), 1, part.size(), pipe))
    out.append(part.data(), bytes);
  EXPECT_EQ(pclose(pipe), 0) << command;
  return out;
}

const std::string kHard[] = {
    "a b",      "it's",        "\"",          "\\",      "a\\",   "$(touch /nowhere/x)",
    "`id`",     "$HOME",       "a;b",         "a && b",  "!x",    "a\nb",
    "\n",       "a\n",         "x\ty",        "\x1b[2J", "\r",    "\x7f",
    "-n",       "a'\\''b",     "*",           "~",       "#",     "a ! fakesink",
    "\xff\xfe", "caf\xc3\xa9", "'\"$(id)\"'", "%s%n%d",  "\\033", "NULL"};

TEST(Pasted, PlainWordsStayAsTheyAre) {
  for (const char* text :
       {"model.onnx", "/a/b-c_d.e", "head:yolox", "rtsp://host:554/x", "a=b,c%@+"}) {
    EXPECT_EQ(shell_word(text), text);
    EXPECT_EQ(launch_value(text), text);
  }
  EXPECT_EQ(shell_word(""), "''");
  EXPECT_EQ(launch_value(""), "'\"\"'");
  EXPECT_EQ(shell_word("a b"), "'a b'");
  EXPECT_EQ(launch_value("a b"), "'\"a b\"'");
  EXPECT_EQ(launch_value("a\"b\\c"), "'\"a\\\"b\\\\c\"'");
}

TEST(Pasted, AShellReadsTheWordAsTheText) {
  for (const std::string& text : kHard) {
    EXPECT_EQ(read_by_shell(shell_word(text)), text + "|");
    EXPECT_EQ(read_by_shell(shell_word(shell_word(text))), shell_word(text) + "|");
  }
}

TEST(Pasted, AShellReadsRandomBytesAsTheText) {
  constexpr std::string_view kSpecial = "'\"\\$`!;&|<>(){}[]*?~# \n\t\r\x1b=";
  std::mt19937 random(20);
  std::string words, expected;
  for (int i = 0; i < 300; ++i) {
    std::string text;
    for (size_t n = random() % 20; n > 0; --n)
      text += random() % 2 ? kSpecial[random() % kSpecial.size()]
                           : static_cast<char>(1 + random() % 255);
    words += " " + shell_word(text);
    expected += text + "|";
  }
  EXPECT_EQ(read_by_shell(words), expected);
}

TEST(Pasted, AreShownWithoutControlCharacters) {
  for (const std::string& text : kHard)
    for (const std::string& shown : {shell_word(text), launch_value(text)})
      EXPECT_EQ(shown.find_first_of("\x1b\r\x7f"), std::string::npos) << shown;
}

TEST(Pasted, TextEndsAtItsFirstNul) {
  const std::string text("a b\0'$(id)", 10);
  EXPECT_EQ(shell_word(text), "'a b'");
  EXPECT_EQ(launch_value(text), "'\"a b\"'");
}

}  // namespace shell_quote_test
}  // namespace weir
