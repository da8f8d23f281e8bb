// Tests damaged TensorFlow Lite models: none crashes or hangs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "damaged_model_test_support.hpp"
#include "tensorflow-lite/tflite_builder_test_support.hpp"

namespace weir::engine_test {
namespace tensorflow_lite_damaged_test {

class TensorflowLiteDamaged : public EngineTest {};

TEST_F(TensorflowLiteDamaged, VersionsOfASmallModelAreRejectedOrRun) {
  const auto counts = run_damaged(*engine(), tflite_negation().bytes(), folder_);
  EXPECT_EQ(counts.refused + counts.failed + counts.ran + counts.large, kDamagedVersions);
  EXPECT_GT(counts.refused, kDamagedVersions / 3) << "what was cut, at least";
}

TEST_F(TensorflowLiteDamaged, VersionsOfRealModelsAreRejectedOrRun) {
  for (const char* file :
       {"models/misc/add.tflite", "models/sensor/point_history_classifier.tflite"}) {
    const auto path = shared_file(file);
    if (path.empty()) GTEST_SKIP() << "../shared/" << file << " is not there";
    const auto counts = run_damaged(*engine(), read_bytes(path), folder_);
    EXPECT_GT(counts.refused, kDamagedVersions / 3) << file;
    EXPECT_GT(counts.ran, 0) << file;
  }
}

}  // namespace tensorflow_lite_damaged_test
}  // namespace weir::engine_test
