// Shared by the tests of sub-plugins: the functions of libnnstreamer.so, which the plug-in loads,
// and temporary folders.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace weir::test {

// The function as in a program that links with libnnstreamer.so; the plug-in uses the same one.
template <class Function>
Function function_of_library(const char* name) {
  static void* library = dlopen(std::getenv("WEIR_NNSTREAMER_LIBRARY"), RTLD_NOW | RTLD_GLOBAL);
  EXPECT_NE(library, nullptr) << dlerror();
  void* found = library ? dlsym(library, name) : nullptr;
  EXPECT_NE(found, nullptr) << name;
  return reinterpret_cast<Function>(found);
}
#define WEIR_LIBRARY(name) ::weir::test::function_of_library<decltype(&name)>(#name)

// A folder for one test; an NNStreamer variable points to it while this object exists.
class SubPluginFolder {
 public:
  explicit SubPluginFolder(const char* variable)
      : variable_(variable),
        path_(std::filesystem::path(::testing::TempDir()) /
              ("weir-sub-plugins-" + std::to_string(getpid())) / variable) {
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
    setenv(variable, path_.c_str(), 1);
  }
  ~SubPluginFolder() {
    unsetenv(variable_);
    std::filesystem::remove_all(path_);
    std::error_code not_empty;
    std::filesystem::remove(path_.parent_path(), not_empty);
  }
  SubPluginFolder(const SubPluginFolder&) = delete;
  SubPluginFolder& operator=(const SubPluginFolder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  const char* variable_;
  std::filesystem::path path_;
};
// The path in the build folder.
inline std::filesystem::path built_sub_plugin(const std::string& name) {
  return std::filesystem::path(std::getenv("WEIR_SUB_PLUGINS")) / name;
}

}  // namespace weir::test
