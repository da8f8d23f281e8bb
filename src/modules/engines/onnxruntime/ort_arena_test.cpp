// Tests of the arena that sessions share: only one exists at a time, and what may outlive it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "onnxruntime/ort_arena.hpp"

#include <algorithm>
#include <fstream>

#include "engine_test_support.hpp"
#include "onnxruntime/onnx_builder_test_support.hpp"

namespace weir::engine_test {
namespace ort_arena_test {

using engine::OrtArena;
using engine::OrtOwner;
using engine::OrtRuntime;
using engine::take;

class Arena : public ::testing::Test {
 protected:
  void SetUp() override {
    auto runtime = OrtRuntime::instance();
    ASSERT_TRUE(runtime) << runtime.error().message();
    runtime_ = *runtime;
  }
  // Whether the environment had an arena; this removes it.
  bool taken_away() const {
    const OrtApi& api = runtime_->api();
    OrtMemoryInfo* raw = nullptr;
    EXPECT_FALSE(take(api, api.CreateCpuMemoryInfo(OrtArenaAllocator, OrtMemTypeDefault, &raw)));
    const OrtOwner<OrtMemoryInfo> memory(raw, api.ReleaseMemoryInfo);
    return !take(api, api.UnregisterAllocator(runtime_->environment(), raw));
  }
  std::shared_ptr<const OrtRuntime> runtime_;
};

TEST_F(Arena, LivesUntilTheLastReferenceIsReleased) {
  ASSERT_FALSE(taken_away());
  auto one = OrtArena::shared(runtime_);
  auto other = OrtArena::shared(runtime_);
  EXPECT_EQ(one, other);
  EXPECT_TRUE(taken_away());
  one = other = nullptr;

  one = OrtArena::shared(runtime_);
  one.reset();
  EXPECT_FALSE(taken_away());
}

TEST_F(Arena, RemovedByOthersIsHandled) {
  const auto arena = OrtArena::shared(runtime_);
  EXPECT_TRUE(taken_away());
}

// y = x * x + x, with an intermediate value that needs memory.
OnnxBuilder square_and_itself() {
  return OnnxBuilder()
      .input("x", kFloat, {"n"})
      .output("y", kFloat, {"m"})
      .node("Mul", {"x", "x"}, {"a"})
      .node("Add", {"a", "x"}, {"y"});
}

size_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  size_t mapped = 0, resident = 0;
  file >> mapped >> resident;
  return resident * 4096;
}

class SharedArena : public EngineTest {
 protected:
  using Opened = Result<std::unique_ptr<OpenEngine>>;
  Opened open(const Options& options = {}) {
    return EngineTest::open(square_and_itself().bytes(), options);
  }
  static void run(const Opened& model, size_t count) {
    ASSERT_TRUE(model) << model.error().message();
    const auto y = (*model)->invoke({make_tensor<float>(WEIR_FLOAT32, {static_cast<int64_t>(count)},
                                                        std::vector<float>(count, 3.0f))});
    ASSERT_TRUE(y) << y.error().message();
    const auto values = (*y)[0].values<float>();
    ASSERT_EQ(values.size(), count);
    EXPECT_TRUE(std::ranges::all_of(values, [](float value) { return value == 12.0f; }));
  }
};

TEST_F(SharedArena, UsesLessMemoryThanSeparateArenas) {
  constexpr size_t kNumbers = size_t{4} << 20, kModels = 8;  // 16 MiB between the operators
  const auto kept_by = [&](const Options& options) {
    const size_t before = resident_bytes();
    std::vector<Opened> models;
    for (size_t i = 0; i < kModels; ++i) models.push_back(open(options));
    for (const auto& model : models) run(model, kNumbers);
    const size_t after = resident_bytes();
    return after > before ? after - before : 0;
  };
  const size_t own = kept_by({{"session.use_env_allocators", "0"}});
  EXPECT_LT(kept_by({}) + (kModels / 2) * kNumbers * sizeof(float), own);
}

TEST_F(SharedArena, OutlivesTheModelsThatUseIt) {
  auto first = open();
  {
    const auto second = open();
    run(second, 1000);
    run(first, 1000);
  }
  run(first, 2000);
  first = open();
  run(first, 5);
}

TEST_F(SharedArena, ModelsCanHaveTheirOwn) {
  const auto own = open({{"session.use_env_allocators", "0"}});
  const auto shared = open();
  run(own, 1000);
  run(shared, 1000);
}

}  // namespace ort_arena_test
}  // namespace weir::engine_test
