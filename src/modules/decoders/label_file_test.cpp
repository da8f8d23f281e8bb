// Tests of weir/label_file.hpp: UTF-8 validation against the number of valid Unicode sequences.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "weir/label_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

namespace weir {
namespace label_file_test {

// Counts the sequences of `length` bytes with a lead byte >= 0x80 that are one valid character.
size_t accepted(size_t length) {
  size_t count = 0;
  std::string text(length, '\0');
  const uint32_t combinations = 1u << (8 * length - 1);
  for (uint32_t i = 0; i < combinations; ++i) {
    text[0] = static_cast<char>(0x80 | (i >> (8 * (length - 1))));
    for (size_t k = 1; k < length; ++k)
      text[k] = static_cast<char>((i >> (8 * (length - 1 - k))) & 0xFF);
    count += utf8_sequence(text) == length;
  }
  return count;
}
// Encodes a code point: the inverse of table 3-6 of the Unicode standard.
std::string encoded(uint32_t c) {
  const auto tail = [c](int shift) { return static_cast<char>(0x80 | ((c >> shift) & 0x3F)); };
  if (c < 0x80) return {static_cast<char>(c)};
  if (c < 0x800) return {static_cast<char>(0xC0 | c >> 6), tail(0)};
  if (c < 0x10000) return {static_cast<char>(0xE0 | c >> 12), tail(6), tail(0)};
  return {static_cast<char>(0xF0 | c >> 18), tail(12), tail(6), tail(0)};
}

TEST(Utf8, HasAsManySequencesAsCharacters) {
  EXPECT_EQ(accepted(2), 0x800u - 0x80u);
  EXPECT_EQ(accepted(3), 0x10000u - 0x800u - 0x800u) << "all but 2048 surrogates";
}

TEST(Utf8, TakesEachCharacterAndNoSurrogate) {
  for (uint32_t c = 0; c < 0x110000; ++c) {
    const bool surrogate = c >= 0xD800 && c < 0xE000;
    const std::string text = encoded(c);
    ASSERT_EQ(utf8_sequence(text), surrogate ? 0 : text.size()) << std::hex << c;
    ASSERT_EQ(utf8_sequence(text.substr(0, text.size() - 1)), 0u) << "cut, " << std::hex << c;
  }
  for (uint32_t c = 0x110000; c < 0x200000; ++c) ASSERT_EQ(utf8_sequence(encoded(c)), 0u);
}

TEST(Utf8, TakesNoLongerFormThanNeeded) {
  for (const char* text : {"\xC0\x80", "\xC1\xBF", "\xE0\x9F\xBF", "\xF0\x8F\xBF\xBF"})
    EXPECT_EQ(utf8_sequence(text), 0u);
}

TEST(Text, HasNoZeroBytes) {
  EXPECT_TRUE(is_text("") && is_text("caf\xC3\xA9"));
  EXPECT_FALSE(is_text(std::string_view("a\0b", 3)));
  EXPECT_FALSE(is_text("caf\xE9"));
  EXPECT_FALSE(is_text("caf\xC3"));
}

Error label_error(const std::string& path) {
  try {
    read_label_file("option1", path);
  } catch (const Failure& failure) {
    return failure.error();
  }
  return {};
}

class LabelFile : public ::testing::Test {
 protected:
  LabelFile() : path_(testing::TempDir() + "weir-label-file-test") {
    std::filesystem::remove(path_);
  }
  ~LabelFile() override { std::filesystem::remove(path_); }
  const std::string path_;
};

TEST_F(LabelFile, IsReadUpTo16MiB) {
  std::ofstream(path_) << std::string(kMaxLabelBytes - 3, 'x') << "\ny\n";
  const auto labels = read_label_file("option1", path_);
  ASSERT_EQ(labels.size(), 2u);
  EXPECT_EQ(labels[0].size(), kMaxLabelBytes - 3);
  EXPECT_EQ(labels[1], "y");
  std::filesystem::resize_file(path_, uintmax_t{1} << 40);  // sparse: uses no space
  const Error error = label_error(path_);
  EXPECT_EQ(error.code, Code::LABELS_INVALID);
  EXPECT_EQ(error.what, "the label file is too large");
  EXPECT_EQ(error.offered, "option1=" + path_);
  EXPECT_EQ(error.needed, "at most 16 MiB");
}

TEST_F(LabelFile, AFifoWithoutAWriterIsRejectedAtOnce) {
  ASSERT_EQ(mkfifo(path_.c_str(), 0600), 0);
  const Error error = label_error(path_);
  EXPECT_EQ(error.code, Code::FILE_NOT_FOUND);
  EXPECT_EQ(error.what, "the label file cannot be read: not a regular file");
}

}  // namespace label_file_test
}  // namespace weir
