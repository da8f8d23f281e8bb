// When a file is read again and when the cache is used.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/config/ini_files.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "core/config/configuration.hpp"

namespace weir::config {
namespace ini_files_test {

namespace fs = std::filesystem;

class IniFilesTest : public ::testing::Test {
 protected:
  IniFilesTest() : path_(fs::path(testing::TempDir()) / "weir-ini-files-test.ini") {
    fs::remove(path_);
  }
  ~IniFilesTest() override { fs::remove(path_); }
  void write(const std::string& text) const { std::ofstream(path_) << text; }
  // Waits until the file's last change is old enough for the cache.
  void wait_until_settled() const {
    for (struct stat file{};;) {
      timespec now{};
      stat(path_.c_str(), &file);
      clock_gettime(CLOCK_REALTIME, &now);
      const double age = static_cast<double>(now.tv_sec - file.st_ctim.tv_sec) +
                         static_cast<double>(now.tv_nsec - file.st_ctim.tv_nsec) * 1e-9;
      if (age > 0.12) return;
    }
  }
  std::string value() {
    const auto ini = files_.read(path_);
    return ini->entries.empty() ? "" : ini->entries[0].value;
  }
  const fs::path path_;
  IniFiles files_;
};

TEST_F(IniFilesTest, ReadsAnUnchangedFileOnce) {
  write("[a]\nb=1\n");
  wait_until_settled();
  EXPECT_EQ(value(), "1");
  EXPECT_EQ(value(), "1");
  EXPECT_EQ(value(), "1");
  EXPECT_EQ(files_.reads(), 1u);
}

TEST_F(IniFilesTest, DetectsAChangeWithinOneTickAtTheSameSize) {
  write("[a]\nb=1\n");
  wait_until_settled();
  EXPECT_EQ(value(), "1");
  for (const char* next : {"2", "3", "4", "5", "6", "7", "8", "9"}) {
    write(std::string("[a]\nb=") + next + "\n");
    EXPECT_EQ(value(), next);
  }
}

TEST_F(IniFilesTest, DetectsADifferentFileWithTheSameNameAndTimes) {
  write("[a]\nb=1\n");
  wait_until_settled();
  EXPECT_EQ(value(), "1");
  const auto time = fs::last_write_time(path_);
  const fs::path other = path_.string() + ".new";
  std::ofstream(other) << "[a]\nb=2\n";
  fs::last_write_time(other, time);
  fs::rename(other, path_);
  EXPECT_EQ(value(), "2");
}

TEST_F(IniFilesTest, ForgetsADeletedFile) {
  write("[a]\nb=1\n");
  wait_until_settled();
  EXPECT_EQ(value(), "1");
  fs::remove(path_);
  const auto gone = files_.read(path_);
  ASSERT_EQ(gone->faults.size(), 1u);
  EXPECT_EQ(gone->faults[0].code, Code::FILE_NOT_FOUND);
  write("[a]\nb=2\n");
  EXPECT_EQ(value(), "2");
}

// Every engine look-up does this.
TEST_F(IniFilesTest, AConfigurationReadsItsFileOnceForAllReaders) {
  write("[module]\npath=/m\n");
  wait_until_settled();
  const std::string name = path_;
  const auto environment = [&](const char* variable) {
    return std::string(variable) == "WEIR_CONFIG" ? name.c_str() : nullptr;
  };
  const auto before = Configuration::files_read();
  for (int i = 0; i < 5; ++i)
    EXPECT_EQ(Configuration(environment).find("module", "path")->value, "/m");
  EXPECT_EQ(Configuration::files_read() - before, 1u);
  write("[module]\npath=/n\n");
  EXPECT_EQ(Configuration(environment).find("module", "path")->value, "/n");
}

}  // namespace ini_files_test
}  // namespace weir::config
