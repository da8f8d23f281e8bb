// Lowers damaged quantised models: each is rejected, left to TensorFlow Lite, or run.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "damaged_model_test_support.hpp"
#include "lowering/lowering_test_support.hpp"

namespace weir::engine_test {
namespace lowering_damaged_test {

// The engine with lowering enabled for every model.
const weir_engine& lowering_engine() {
  static const weir_engine table = [] {
    weir_engine out = *engine();
    out.open = [](const weir_open* request, weir_model** model, weir_error* error) {
      static const weir_option options[] = {{"Lowering", "onnxruntime"}};
      weir_open with = *request;
      with.options = options;
      with.n_options = 1;
      return engine()->open(&with, model, error);
    };
    return out;
  }();
  return table;
}

class LoweringDamaged : public LoweringTest {};

TEST_F(LoweringDamaged, VersionsOfASmallModelAreRejectedOrRun) {
  const auto model = TfliteBuilder()
                         .input("x", kTfUint8, {1, 4})
                         .quantized({{0.5f}, {10}})
                         .constant<uint8_t>("w", kTfUint8, {2, 4}, {1, 2, 3, 4, 5, 6, 7, 8})
                         .quantized({{0.1f}, {4}})
                         .tensor("h", kTfUint8, {1, 2})
                         .quantized({{0.7f}, {3}})
                         .constant<int32_t>("shape", kTfInt32, {2}, {2, 1})
                         .output("y", kTfUint8, {2, 1})
                         .quantized({{0.7f}, {3}})
                         .node(kOpFullyConnected, {"x", "w", ""}, {"h"})
                         .node(kOpReshape, {"h", "shape"}, {"y"});
  ASSERT_NE(lowered(folder_.write("whole.tflite", model.bytes())), nullptr);
  const auto counts = run_damaged(lowering_engine(), model.bytes(), folder_);
  EXPECT_EQ(counts.refused + counts.failed + counts.ran + counts.large, kDamagedVersions);
  EXPECT_GT(counts.refused, kDamagedVersions / 3) << "what was cut, at least";
  EXPECT_GT(counts.ran, 0);
}

TEST_F(LoweringDamaged, VersionsOfARealModelAreRejectedOrRun) {
  const auto path = shared_file("models/audio/micro_speech_quantized.tflite");
  if (path.empty()) GTEST_SKIP() << "../shared/models/audio is not there";
  const auto counts = run_damaged(lowering_engine(), read_bytes(path), folder_);
  EXPECT_GT(counts.refused, kDamagedVersions / 3);
  EXPECT_GT(counts.ran, 0);
}

}  // namespace lowering_damaged_test
}  // namespace weir::engine_test
