// Tests which file of an installation a path below another prefix means.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/config/installed_file.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace weir::config {
namespace installed_file_test {

namespace fs = std::filesystem;

class InstalledFile : public testing::Test {
 protected:
  InstalledFile() : data_(fs::path(testing::TempDir()) / "weir-installed-file-test/share/weir") {
    fs::create_directories(data_ / "models");
    std::ofstream(data_ / "models/digits.onnx") << "a model";
  }
  ~InstalledFile() override { fs::remove_all(data_.parent_path().parent_path()); }

  std::string found(const std::string& path) { return file_below(data_.string(), path); }

  fs::path data_;
};

TEST_F(InstalledFile, IsThatOfTheOtherPrefix) {
  const std::string file = (data_ / "models/digits.onnx").string();
  EXPECT_EQ(found("/usr/share/weir/models/digits.onnx"), file);
  EXPECT_EQ(found("/opt/w/share/weir/models/digits.onnx"), file);
}

TEST_F(InstalledFile, IsNoneForOtherPaths) {
  for (const char* path :
       {"/usr/share/weir/models/none.onnx", "/usr/share/weir/models", "/usr/share/weir/",
        "/usr/share/models/digits.onnx", "models/digits.onnx", ""})
    EXPECT_EQ(found(path), "") << path;
  EXPECT_EQ(found((data_ / "models/digits.onnx").string()), "") << "it is that file";
}

TEST_F(InstalledFile, IsNotLookedForWhereThePathExists) {
  EXPECT_EQ(installed_file((data_ / "models/digits.onnx").string()), "");
  EXPECT_EQ(installed_file("/nowhere/share/weir/models/none.onnx"), "");
}

}  // namespace installed_file_test
}  // namespace weir::config
