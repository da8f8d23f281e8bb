// Files that cannot be read, and why.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/text_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace weir {
namespace text_file_test {

class Unreadable : public testing::Test {
 protected:
  Unreadable() { std::filesystem::create_directories(folder_); }
  ~Unreadable() override { std::filesystem::remove_all(folder_); }

  const std::string folder_ = testing::TempDir() + "weir-unreadable";
};

TEST_F(Unreadable, GivesTheReason) {
  const std::string fifo = folder_ + "/fifo";
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  EXPECT_EQ(why_unreadable(folder_), "it is a folder");
  EXPECT_EQ(why_unreadable(folder_ + "/none"), "it does not exist");
  EXPECT_EQ(why_unreadable(""), "it does not exist");
  EXPECT_EQ(why_unreadable(fifo), "it is not a regular file");
  EXPECT_NE(why_unreadable(std::string(5000, 'x')), "");
}

TEST_F(Unreadable, IsEmptyForAFileThatCanBeRead) {
  std::ofstream(folder_ + "/file") << "text";
  EXPECT_EQ(why_unreadable(folder_ + "/file"), "");
}

}  // namespace text_file_test
}  // namespace weir
