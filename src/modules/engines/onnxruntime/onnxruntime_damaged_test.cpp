// Tests damaged ONNX models: none crashes or hangs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "damaged_model_test_support.hpp"
#include "onnxruntime/onnx_builder_test_support.hpp"

namespace weir::engine_test {
namespace onnxruntime_damaged_test {

class OnnxRuntimeDamaged : public EngineTest {};

TEST_F(OnnxRuntimeDamaged, VersionsOfASmallModelAreRejectedOrRun) {
  const auto whole = OnnxBuilder()
                         .input("x", kFloat, {"2", "3"})
                         .output("y", kFloat, {"3", "2"})
                         .constant("shape", {3, 2})
                         .node("Neg", {"x"}, {"n"})
                         .node("Reshape", {"n", "shape"}, {"y"})
                         .bytes();
  const auto counts = run_damaged(*engine(), whole, folder_);
  EXPECT_EQ(counts.refused + counts.failed + counts.ran + counts.large, kDamagedVersions);
  EXPECT_GT(counts.refused, kDamagedVersions / 3) << "what was cut, at least";
}

TEST_F(OnnxRuntimeDamaged, VersionsOfARealModelAreRejectedOrRun) {
  const auto path = shared_file("models/sensor/point_history_classifier_lstm.onnx");
  if (path.empty()) GTEST_SKIP() << "../shared/models/sensor is not there";
  const auto counts = run_damaged(*engine(), read_bytes(path), folder_);
  EXPECT_GT(counts.refused, kDamagedVersions / 3);
  EXPECT_GT(counts.ran, 0) << "weights take most of its bytes";
}

}  // namespace onnxruntime_damaged_test
}  // namespace weir::engine_test
