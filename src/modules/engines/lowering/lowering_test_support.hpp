// Test fixture that runs a .tflite model in TensorFlow Lite and lowered, and compares the outputs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <random>

#include "engine_test_support.hpp"
#include "says.hpp"
#include "tensorflow-lite/tflite_builder_test_support.hpp"

namespace weir::engine_test {

inline const weir_engine* other_engine() {
  static const weir_engine* const loaded = load_module(WEIR_OTHER_MODULE_FILE);
  return loaded;
}

struct Comparison {
  int worst = 0;                         // quantisation steps
  double differing = 0, beyond_one = 0;  // fractions of all values
  std::vector<size_t> own_argmax, lowered_argmax;
};

// Skipped unless both libraries are installed.
class LoweringTest : public EngineTest {
 protected:
  inline static const Options kLowered{{"Lowering", "onnxruntime"}};

  void SetUp() override {
    EngineTest::SetUp();
    if (IsSkipped()) return;
    ASSERT_NE(other_engine(), nullptr);
    if (!other_engine()->extension("weir.library/1"))
      GTEST_SKIP() << "onnxruntime is not installed";
    let_find("onnxruntime", other_engine());
  }

  // The log text since the last call.
  static std::string logged() {
    std::string out;
    for (const auto& line : take_log()) out += line + "\n";
    return out;
  }
  // Null, with a test failure, when ONNX Runtime does not run the model.
  static std::unique_ptr<OpenEngine> lowered(const std::string& path) {
    take_log();
    auto model = OpenEngine::open(*engine(), path, kLowered, 1);
    const std::string words = logged();
    EXPECT_SAYS(words, "ONNX Runtime runs");
    if (!model) ADD_FAILURE() << model.error().message();
    return model ? *std::move(model) : nullptr;
  }

  static int step(const TestTensor& tensor, size_t index) {
    const auto value = std::to_integer<uint8_t>(tensor.bytes[index]);
    return tensor.info.type == WEIR_INT8 ? static_cast<int8_t>(value) : value;
  }
  // For models with 8-bit inputs and outputs.
  static void compare(OpenEngine* own, OpenEngine* other, const std::vector<TestTensor>& inputs,
                      Comparison* out) {
    const auto expected = own->invoke(inputs), found = other->invoke(inputs);
    ASSERT_TRUE(expected) << expected.error().message();
    ASSERT_TRUE(found) << found.error().message();
    ASSERT_EQ(expected->size(), found->size());
    size_t count = 0, differing = 0, beyond = 0;
    for (size_t i = 0; i < found->size(); ++i) {
      const auto &a = (*expected)[i], &b = (*found)[i];
      ASSERT_EQ(to_string(a.info), to_string(b.info));
      ASSERT_EQ(a.bytes.size(), b.bytes.size());
      size_t best_a = 0, best_b = 0;
      for (size_t at = 0; at < a.bytes.size(); ++at) {
        const int steps = std::abs(step(a, at) - step(b, at));
        out->worst = std::max(out->worst, steps);
        differing += steps > 0;
        beyond += steps > 1;
        if (step(a, at) > step(a, best_a)) best_a = at;
        if (step(b, at) > step(b, best_b)) best_b = at;
      }
      count += a.bytes.size();
      out->own_argmax.push_back(best_a);
      out->lowered_argmax.push_back(best_b);
    }
    out->differing = static_cast<double>(differing) / static_cast<double>(count);
    out->beyond_one = static_cast<double>(beyond) / static_cast<double>(count);
  }
  static std::vector<TestTensor> random_inputs(const OpenEngine& model, uint32_t seed) {
    std::mt19937 random(seed);
    auto out = zero_inputs(model);
    for (auto& tensor : out)
      for (auto& value : tensor.bytes) value = std::byte(random() & 255);
    return out;
  }
};

}  // namespace weir::engine_test
