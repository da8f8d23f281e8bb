// The tokens that clients of a server may send.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "net/protocol/token_file.hpp"
#include "says.hpp"

namespace weir::net {
namespace token_file_test {

class Tokens : public ::testing::Test {
 protected:
  Tokens() : folder_(::testing::TempDir() + "weir-tokens-" + std::to_string(getpid())) {
    std::filesystem::create_directories(folder_);
  }
  ~Tokens() override { std::filesystem::remove_all(folder_); }
  // Replaces the file.
  std::string write(const std::string& text) {
    std::ofstream(folder_ + "/new") << text;
    std::filesystem::rename(folder_ + "/new", path_);
    return path_;
  }

  const std::string folder_, path_ = folder_ + "/tokens";
};

TEST_F(Tokens, AreComparedWhole) {
  auto tokens = TokenFile::open(write("one\r\n\nanother"));
  ASSERT_TRUE(tokens);
  EXPECT_TRUE((*tokens)->allows("Bearer one"));
  EXPECT_TRUE((*tokens)->allows("Bearer another"));
  for (const auto* wrong :
       {"", "one", "bearer one", "Bearer ", "Bearer on", "Bearer onf", "Bearer one "})
    EXPECT_FALSE((*tokens)->allows(wrong)) << wrong;
}

TEST_F(Tokens, AreReadAgainWhenTheFileIsReplaced) {
  auto tokens = TokenFile::open(write("one\n"));
  ASSERT_TRUE(tokens);
  write("two\n");
  EXPECT_FALSE((*tokens)->allows("Bearer one"));
  EXPECT_TRUE((*tokens)->allows("Bearer two"));
}

TEST_F(Tokens, StayWhileTheFileHasNone) {
  auto tokens = TokenFile::open(write("one\n"));
  ASSERT_TRUE(tokens);
  write("\n");
  EXPECT_TRUE((*tokens)->allows("Bearer one"));
  std::filesystem::remove(path_);
  EXPECT_TRUE((*tokens)->allows("Bearer one"));
  write("two\n");
  EXPECT_FALSE((*tokens)->allows("Bearer one"));
}

TEST_F(Tokens, FilesWithoutATokenAreErrors) {
  EXPECT_SAYS(TokenFile::open(folder_ + "/none").error().message(),
              "WEIR-4001: the file of the property token-file cannot be read");
  EXPECT_SAYS(TokenFile::open(write("\r\n\n")).error().message(),
              "WEIR-1004: the file of the property token-file has no token");
}

TEST_F(Tokens, ThatNoClientCanSendAreErrors) {
  const struct {
    const char *text, *offered;
  } cases[] = {{"\xEF\xBB\xBFone\n", "a UTF-8 byte order mark in column 1 of line 1 of "},
               {"one\n\ntwo\t\n", "the byte 0x09 in column 4 of line 3 of "},
               {"one\nt\xC3\xBC\n", "the byte 0xC3 in column 2 of line 2 of "},
               {"one\rtwo", "the byte 0x0D in column 4 of line 1 of "}};
  for (const auto& c : cases) {
    const std::string text = TokenFile::open(write(c.text)).error().message();
    EXPECT_SAYS(text, "WEIR-1004: the file of the property token-file has a token that cannot");
    EXPECT_SAYS(text, std::string("offered: ") + c.offered + path_);
    EXPECT_SAYS(text, "fix: LC_ALL=C sed -i 's/[^ -~]//g' " + path_);
    EXPECT_EQ(text.find("one"), std::string::npos) << text;
  }
}

TEST_F(Tokens, ThatNoClientCanSendAreIgnoredWhenTheFileIsReplaced) {
  auto tokens = TokenFile::open(write("one\n"));
  ASSERT_TRUE(tokens);
  write("two\nthr\xC3\xA9\n");
  EXPECT_FALSE((*tokens)->allows("Bearer one"));
  EXPECT_TRUE((*tokens)->allows("Bearer two"));
  EXPECT_FALSE((*tokens)->allows("Bearer thr\xC3\xA9"));
  write("\xC3\xA9\n");
  EXPECT_TRUE((*tokens)->allows("Bearer two"));
}

TEST(HeaderTexts, ArePrintableAscii) {
  for (int byte = 0; byte < 256; ++byte)
    EXPECT_EQ(is_header_value(std::string(1, static_cast<char>(byte))), byte >= 32 && byte < 127)
        << byte;
  EXPECT_TRUE(is_header_value(""));
  EXPECT_FALSE(is_header_value("\xEF\xBB\xBFtoken"));
}

}  // namespace token_file_test
}  // namespace weir::net
