// Tests weir_module_entry of each module: NULL for an incompatible host, and no crash.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "weir/abi.h"

namespace entry_test {

using Entry = const weir_module* (*)(const weir_host*);

std::vector<std::string> modules() {
  std::vector<std::string> out;
  const char* list = std::getenv("WEIR_TEST_MODULE_FILES");
  std::istringstream text(list ? list : "");
  for (std::string path; std::getline(text, path, ':');) out.push_back(path);
  return out;
}

int logged = 0;
weir_host host() {
  weir_host out{};
  out.struct_size = sizeof out;
  out.abi_major = WEIR_ABI_MAJOR;
  out.abi_minor = WEIR_ABI_MINOR;
  out.log = [](int, const char*, const char*) { ++logged; };
  return out;
}

class ModuleEntry : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    handle_ = dlopen(GetParam().c_str(), RTLD_NOW | RTLD_LOCAL);
    ASSERT_NE(handle_, nullptr) << dlerror();
    entry_ = reinterpret_cast<Entry>(dlsym(handle_, "weir_module_entry"));
    ASSERT_NE(entry_, nullptr);
    logged = 0;
  }
  void TearDown() override {
    if (handle_) dlclose(handle_);
  }
  void* handle_ = nullptr;
  Entry entry_ = nullptr;
};

TEST_P(ModuleEntry, ReturnsTheTablesOfThisVersion) {
  static const weir_host good = host();  // abi.h requires it to exist until the process exits
  const weir_module* module = entry_(&good);
  ASSERT_NE(module, nullptr);
  EXPECT_EQ(module->abi_major, WEIR_ABI_MAJOR);
  EXPECT_EQ(module->struct_size, sizeof(weir_module));
  const bool something = (module->engines && module->engines[0]) ||
                         (module->decoders && module->decoders[0]) ||
                         (module->converters && module->converters[0]);
  EXPECT_TRUE(something);
}

TEST_P(ModuleEntry, RejectsAMissingHost) {
  EXPECT_EQ(entry_(nullptr), nullptr);
}

TEST_P(ModuleEntry, RejectsAndReportsAHostOfAnotherMajorVersion) {
  weir_host other = host();
  ++other.abi_major;
  EXPECT_EQ(entry_(&other), nullptr);
  EXPECT_EQ(logged, 1);
}

TEST_P(ModuleEntry, RejectsAHostWhoseTableIsTooShort) {
  weir_host shorter = host();
  shorter.struct_size = offsetof(weir_host, extension);
  EXPECT_EQ(entry_(&shorter), nullptr);
}

INSTANTIATE_TEST_SUITE_P(Each, ModuleEntry, testing::ValuesIn(modules()));

TEST(ModuleEntryTests, HaveModules) {
  EXPECT_GE(modules().size(), 5u);
}

}  // namespace entry_test
