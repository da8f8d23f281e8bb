// Tests zip archives that no writer produces: each byte is read once, whatever the directory says.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pytorch/torch_file.hpp"

#include <gtest/gtest.h>

#include <istream>

#include "pytorch/source_buffer.hpp"
#include "pytorch/torchscript_builder_test_support.hpp"
#include "says.hpp"

namespace weir::engine {
namespace torch_file_test {

// An archive of stored or compressed data with an arbitrary directory.
class CraftedZip {
 public:
  // Returns the offset of the entry's header.
  uint32_t add_data(const std::string& name, const std::string& data) {
    const auto at = static_cast<uint32_t>(bytes_.size());
    number(0x04034b50, 4).number(20, 2).number(0, 8);
    number(checksum(data), 4).number(data.size(), 4).number(data.size(), 4);
    number(name.size(), 2).number(0, 2);
    bytes_ += name + data;
    return at;
  }
  void add_entry(const std::string& name, const std::string& data, uint32_t at, uint16_t method = 0,
                 uint32_t bytes = 0) {
    std::swap(bytes_, directory_);
    number(0x02014b50, 4).number(20, 2).number(20, 2).number(0, 2).number(method, 2).number(0, 4);
    number(checksum(data), 4).number(data.size(), 4).number(bytes ? bytes : data.size(), 4);
    number(name.size(), 2).number(0, 12).number(at, 4);
    bytes_ += name;
    std::swap(bytes_, directory_);
    ++entries_;
  }
  Error error() {
    const size_t at = bytes_.size(), size = directory_.size();
    bytes_ += directory_;
    number(0x06054b50, 4).number(0, 4).number(entries_, 2).number(entries_, 2);
    number(size, 4).number(at, 4).number(0, 2);
    const auto found = check_torch_file(ModelSource(std::as_bytes(std::span(bytes_))));
    return found ? Error{.code = Code::INTERNAL, .what = "it is good"} : found.error();
  }

 private:
  static uint32_t checksum(const std::string& data) {
    return crc32(std::as_bytes(std::span(data)));
  }
  CraftedZip& number(uint64_t value, int count) {
    for (int i = 0; i < count; ++i) bytes_ += static_cast<char>(i < 8 ? value >> 8 * i & 0xFF : 0);
    return *this;
  }

  std::string bytes_, directory_;
  uint16_t entries_ = 0;
};

TEST(TorchFile, ChecksumsContinueAcrossPieces) {
  const std::string text = "123456789";  // the check input of CRC-32/ISO-HDLC
  const auto bytes = std::as_bytes(std::span(text));
  EXPECT_EQ(crc32(bytes), 0xCBF43926u);
  EXPECT_EQ(crc32(bytes.subspan(4), crc32(bytes.first(4))), 0xCBF43926u);
}

TEST(TorchFile, ADuplicateNameIsRejected) {
  CraftedZip zip;
  const std::string data(1 << 20, '\0');
  const uint32_t at = zip.add_data("m/code/x", data);
  for (int i = 0; i < 60000; ++i) zip.add_entry("m/code/x", data.substr(0, 0), at);
  const Error error = zip.error();
  EXPECT_EQ(error.code, Code::MODEL_INVALID);
  EXPECT_SAYS(error.message(), "m/code/x is in the archive twice");
}

TEST(TorchFile, EntriesThatShareBytesAreRejected) {
  CraftedZip zip;
  const std::string data(1000, 'x');
  const uint32_t at = zip.add_data("m/code/a", data);
  zip.add_entry("m/code/a", data, at);
  zip.add_entry("m/code/b", data, at);
  const Error error = zip.error();
  EXPECT_EQ(error.code, Code::MODEL_INVALID);
  EXPECT_SAYS(error.message(), "two entries of the archive share bytes at 0");
}

TEST(TorchFile, ANestedEntryIsRejected) {
  CraftedZip zip;
  const std::string header("PK\3\4", 4);
  const std::string data = std::string(100, 'x') + header + std::string(26, '\0') + "tail";
  const uint32_t at = zip.add_data("m/code/a", data);
  zip.add_entry("m/code/a", data, at);
  zip.add_entry("m/code/b", "tail", at + 30 + 8 + 100);
  EXPECT_SAYS(zip.error().message(), "two entries of the archive share bytes");
}

TEST(TorchFile, AnImpossibleCompressedSizeIsRejected) {
  CraftedZip zip;
  const std::string data(10, 'x');
  const uint32_t at = zip.add_data("m/code/a", data);
  zip.add_entry("m/code/a", data, at, 8, 1 << 30);
  EXPECT_SAYS(zip.error().message(), "code/a has an impossible compressed size");
}

TEST(TorchFile, SeparateEntriesAreRead) {
  CraftedZip zip;
  const std::string data = "some code";
  for (const char* name : {"m/code/a", "m/data.pkl", "m/constants.pkl"})
    zip.add_entry(name, data, zip.add_data(name, data));
  EXPECT_EQ(zip.error().what, "it is good");
}

TEST(SourceBuffer, ReadsAndSeeksAsAFileDoes) {
  std::string text;
  for (int i = 0; i < 200000; ++i) text += static_cast<char>('a' + i % 26);
  const ModelSource source(std::as_bytes(std::span(text)));
  SourceBuffer buffer(source);
  std::istream stream(&buffer);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(stream), {}), text);
  stream.clear();
  stream.seekg(0, std::ios::end);
  EXPECT_EQ(stream.tellg(), std::streamoff(text.size()));
  stream.seekg(99990);
  std::string part(20, ' ');
  EXPECT_TRUE(stream.read(part.data(), 20));
  EXPECT_EQ(part, text.substr(99990, 20));
  EXPECT_EQ(stream.get(), text[100010]);
  EXPECT_EQ(stream.tellg(), 100011);
  stream.seekg(-5, std::ios::end);
  EXPECT_FALSE(stream.read(part.data(), 20));
  EXPECT_EQ(stream.gcount(), 5);
  stream.clear();
  EXPECT_FALSE(stream.seekg(200001));
}

}  // namespace torch_file_test
}  // namespace weir::engine
