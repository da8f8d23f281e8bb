// Test fixture of one engine module, whose path is WEIR_MODULE_FILE.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "engine_host_test_support.hpp"
#include "says.hpp"

namespace weir::engine_test {

inline const weir_engine* engine() {
  static const weir_engine* const loaded = load_module(WEIR_MODULE_FILE);
  return loaded;
}

// Skipped where the engine's library is not installed.
class EngineTest : public ::testing::Test {
 protected:
  using Options = OpenEngine::Options;

  void SetUp() override {
    ASSERT_NE(engine(), nullptr);
    if (!engine()->extension("weir.library/1"))
      GTEST_SKIP() << engine()->name << " is not installed";
    take_log();
  }
  Result<std::unique_ptr<OpenEngine>> open(const std::vector<std::byte>& bytes,
                                           const Options& options = {}, int threads = 0) {
    return OpenEngine::open(*engine(), folder_.write("model.bin", bytes), options, threads);
  }
  // Null, with a test failure, when the model cannot be opened.
  static std::unique_ptr<OpenEngine> opened(const std::string& path, const Options& options = {}) {
    auto model = OpenEngine::open(*engine(), path, options);
    if (!model) ADD_FAILURE() << path << ": " << model.error().message();
    return model ? *std::move(model) : nullptr;
  }
  std::unique_ptr<OpenEngine> opened(const std::vector<std::byte>& bytes,
                                     const Options& options = {}) {
    auto model = open(bytes, options);
    if (!model) ADD_FAILURE() << model.error().message();
    return model ? *std::move(model) : nullptr;
  }
  Error get_error(const std::vector<std::byte>& bytes, const Options& options = {}) {
    const auto model = open(bytes, options);
    return model ? Error{.code = Code::INTERNAL, .what = "it opened"} : model.error();
  }

  TemporaryFolder folder_;
};

}  // namespace weir::engine_test
