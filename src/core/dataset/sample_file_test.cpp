// Files of samples: read at an offset, appended to, and locations that cannot be used.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/dataset/sample_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <vector>

#include "says.hpp"

namespace weir::dataset {
namespace sample_file_test {

namespace fs = std::filesystem;

class SampleFiles : public testing::Test {
 protected:
  SampleFiles() { fs::create_directories(folder_); }
  SampleFiles(const SampleFiles&) = delete;
  SampleFiles& operator=(const SampleFiles&) = delete;
  ~SampleFiles() override { fs::remove_all(folder_); }

  std::string path(const char* name) const { return folder_ / name; }
  std::string write(const char* name, const std::string& text) const {
    std::ofstream(path(name)) << text;
    return path(name);
  }
  static std::string read(const SampleFile& file, uint64_t offset, size_t bytes) {
    std::string out(bytes, '\0');
    const auto status = file.read(offset, std::as_writable_bytes(std::span(out)));
    return status ? out : status.error().message();
  }

  fs::path folder_ =
      fs::path(testing::TempDir()) / ("weir-sample-files-" + std::to_string(getpid()));
};

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text));
}

TEST_F(SampleFiles, AreReadAtAnyOffset) {
  const auto file = SampleFile::open("location", write("a", "0123456789"));
  ASSERT_TRUE(file);
  EXPECT_EQ(file->bytes(), 10u);
  EXPECT_EQ(read(*file, 3, 4), "3456");
  EXPECT_EQ(read(*file, 0, 10), "0123456789");
  EXPECT_EQ(read(*file, 10, 0), "");
}

// A sparse file of 5 TiB; only its ends have content.
TEST_F(SampleFiles, AreReadBeyondWhatFitsIntoMemory) {
  constexpr uint64_t kEnd = uint64_t{5} << 40;
  const std::string name = path("huge");
  {
    auto file = SampleWriter::create("location", name);
    ASSERT_TRUE(file);
    if (truncate(name.c_str(), static_cast<off_t>(kEnd)) != 0)
      GTEST_SKIP() << "the file system has no such files";
    std::ofstream(name, std::ios::app) << "end";
  }
  const auto file = SampleFile::open("location", name);
  ASSERT_TRUE(file);
  EXPECT_EQ(file->bytes(), kEnd + 3);
  EXPECT_EQ(read(*file, kEnd, 3), "end");
}

TEST_F(SampleFiles, ThatEndTooEarlyAreNamed) {
  const auto file = SampleFile::open("location", write("a", "0123"));
  EXPECT_SAYS(read(*file, 2, 3), "a sample is cut off by the end of the file\n  offered: " +
                                     path("a") + ": 4 bytes\n  needed: 5 bytes");
  EXPECT_SAYS(read(*file, UINT64_MAX, 3), "a sample lies beyond the end of any file");
  EXPECT_SAYS(read(*file, INT64_MAX, 3), "a sample lies beyond the end of any file");
}

TEST_F(SampleFiles, ThatCannotBeReadAreNamed) {
  const auto refused = SampleFile::open("json", path("none"));
  EXPECT_REFUSED(refused, FILE_NOT_FOUND,
                 "the file of json cannot be read: No such file or directory");
  EXPECT_REFUSED(refused, FILE_NOT_FOUND, "offered: " + path("none"));
  EXPECT_REFUSED(SampleFile::open("json", folder_), FILE_NOT_FOUND, "it is a folder");
  ASSERT_EQ(mkfifo(path("fifo").c_str(), 0600), 0);
  EXPECT_REFUSED(SampleFile::open("json", path("fifo")), FILE_NOT_FOUND, "it is no regular file");
  EXPECT_REFUSED(SampleFile::open("json", ""), FILE_NOT_FOUND, "No such file or directory");
}

TEST_F(SampleFiles, AreTruncatedAndThenAppendedTo) {
  write("a", "what was there before");
  auto writer = SampleWriter::create("location", path("a"));
  ASSERT_TRUE(writer);
  EXPECT_TRUE(writer->append(bytes_of("012")));
  EXPECT_TRUE(writer->append(bytes_of("")));
  EXPECT_TRUE(writer->append(bytes_of("345")));
  EXPECT_EQ(writer->bytes(), 6u);
  writer->cut(4);
  EXPECT_EQ(writer->bytes(), 4u);
  EXPECT_TRUE(writer->append(bytes_of("6")));
  EXPECT_TRUE(writer->close());
  EXPECT_TRUE(writer->close());
  EXPECT_FALSE(*writer);
  EXPECT_EQ(*read_text("location", path("a"), 100), "01236");
}

TEST_F(SampleFiles, HaveTheMode0644) {
  const mode_t before = umask(0);
  EXPECT_TRUE(write_text("json", path("a"), "{}"));
  umask(before);
  struct stat about {};
  ASSERT_EQ(stat(path("a").c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 07777, mode_t{0644});
}

TEST_F(SampleFiles, ThatCannotBeWrittenAreNamed) {
  EXPECT_REFUSED(SampleWriter::create("location", path("no/a")), FILE_NOT_WRITTEN,
                 "the file of location cannot be written: No such file or directory");
  EXPECT_REFUSED(write_text("json", path("no/a"), ""), FILE_NOT_WRITTEN,
                 "fix: mkdir -p " + path("no"));
  EXPECT_REFUSED(write_text("json", folder_, ""), FILE_NOT_WRITTEN, "Is a directory");
}

TEST_F(SampleFiles, ReportAFullDisk) {
  if (!fs::exists("/dev/full")) GTEST_SKIP();
  auto writer = SampleWriter::create("location", "/dev/full");
  ASSERT_TRUE(writer);
  EXPECT_REFUSED(writer->append(bytes_of("x")), FILE_NOT_WRITTEN,
                 "the file of location cannot be written: No space left on device\n  offered: "
                 "/dev/full");
  EXPECT_EQ(writer->bytes(), 0u);
  writer->cut(0);
  EXPECT_REFUSED(write_text("json", "/dev/full", "x"), FILE_NOT_WRITTEN, "fix: df -h /dev");
}

TEST_F(SampleFiles, TextsHaveALimit) {
  EXPECT_EQ(*read_text("json", write("a", "1234"), 4), "1234");
  EXPECT_REFUSED(read_text("json", path("a"), 3), LIMIT_EXCEEDED,
                 "offered: " + path("a") + ": 4 bytes\n  needed: at most 3 bytes");
}

TEST_F(SampleFiles, AreCheckedBeforeTheyAreWritten) {
  EXPECT_TRUE(check_writable("json", path("new")));
  EXPECT_FALSE(fs::exists(path("new")));
  EXPECT_TRUE(check_writable("json", write("old", "")));
  EXPECT_TRUE(check_writable("json", "in-the-current-folder"));
  EXPECT_REFUSED(check_writable("json", path("no/a")), FILE_NOT_WRITTEN, "No such file");
  EXPECT_REFUSED(check_writable("json", path("old/a")), FILE_NOT_WRITTEN, "Not a directory");
  EXPECT_REFUSED(check_writable("json", folder_), FILE_NOT_WRITTEN, "Is a directory");
}

}  // namespace sample_file_test
}  // namespace weir::dataset
