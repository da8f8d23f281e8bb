// Tests real quantised models: TensorFlow Lite and the lowered graph on the same frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>
#include <nlohmann/json.hpp>

#include "lowering/lowering_test_support.hpp"
#include "says.hpp"

namespace weir::engine_test {
namespace lowering_models_test {

class LoweringModels : public LoweringTest {};

// Waves of colour, which activate networks; noise alone does not.
std::vector<TestTensor> waves(const OpenEngine& model, int number) {
  auto out = zero_inputs(model);
  for (auto& tensor : out)
    for (size_t i = 0; i < tensor.bytes.size(); ++i) {
      const auto at = static_cast<double>(i);
      const double value = std::sin(at / (7 + number)) + std::cos(at / (941 + 37 * number));
      tensor.bytes[i] = static_cast<std::byte>(128 + static_cast<int>(60 * value));
    }
  return out;
}

TEST_F(LoweringModels, MobilenetAgrees) {
  const auto path = shared_file("models/classification/mobilenet_v2_1.0_224_quant.tflite");
  if (path.empty()) GTEST_SKIP() << "../shared/models/classification is not there";
  const auto own = opened(path), other = lowered(path);
  ASSERT_NE(own, nullptr);
  ASSERT_NE(other, nullptr);
  EXPECT_STREQ(other->inputs()[0].name, own->inputs()[0].name);
  EXPECT_STREQ(other->outputs()[0].name, own->outputs()[0].name);
  EXPECT_EQ(other->inputs()[0].scale, own->inputs()[0].scale);
  EXPECT_EQ(other->inputs()[0].zero_point, own->inputs()[0].zero_point);
  EXPECT_EQ(other->outputs()[0].scale, own->outputs()[0].scale);
  EXPECT_EQ(other->outputs()[0].zero_point, own->outputs()[0].zero_point);
  for (int number = 0; number < 4; ++number) {
    Comparison found;
    compare(own.get(), other.get(), waves(*own, number), &found);
    EXPECT_LE(found.worst, 8) << number;
    EXPECT_LT(found.beyond_one, 0.5) << number;
  }
}

// Covers CAST, GATHER_ND and ARG_MAX around the layers; real pictures: tests/pipelines.
TEST_F(LoweringModels, MovenetRunsFromBytesToKeyPointsAndScores) {
  const auto path = shared_file("models/pose/movenet_lightning_ptq.tflite");
  if (path.empty()) GTEST_SKIP() << "../shared/models/pose is not there";
  const auto other = lowered(path);
  ASSERT_NE(other, nullptr);
  const auto found = other->invoke(waves(*other, 1));
  ASSERT_TRUE(found) << found.error().message();
  const auto values = (*found)[0].values<float>();
  ASSERT_EQ(values.size(), 51u);
  for (const float value : values) {
    EXPECT_GE(value, 0);
    EXPECT_LE(value, 1.05f);
  }
}

TEST_F(LoweringModels, ACustomOperatorStaysWithTensorFlowLiteAndIsNamed) {
  const auto path = shared_file("models/detection/coco_ssd_mobilenet_v1_1.0_quant.tflite");
  if (path.empty()) GTEST_SKIP() << "../shared/models/detection is not there";
  take_log();
  const auto model = OpenEngine::open(*engine(), path, kLowered, 1);
  ASSERT_TRUE(model) << model.error().message();
  const std::string words = logged();
  EXPECT_SAYS(words, "TFLite_Detection_PostProcess (number 64) is not lowered");
  EXPECT_SAYS(words, "TensorFlow Lite runs it");
  const auto metadata = nlohmann::json::parse((*model)->info().metadata_json);
  EXPECT_EQ(metadata["lowering"],
            "none: the operator TFLite_Detection_PostProcess (number 64) is not lowered to ONNX "
            "Runtime");
  EXPECT_TRUE(metadata.contains("operators")) << "and the engine's own metadata";
  EXPECT_TRUE((*model)->invoke(zero_inputs(**model)));
}

TEST_F(LoweringModels, YamnetStaysWithTensorFlowLiteForItsFourierTransform) {
  const auto path = shared_file("models/audio/yamnet.tflite");
  if (path.empty()) GTEST_SKIP() << "../shared/models/audio is not there";
  const auto model = OpenEngine::open(*engine(), path, kLowered, 1);
  ASSERT_TRUE(model) << model.error().message();
  const auto metadata = nlohmann::json::parse((*model)->info().metadata_json);
  const auto why = metadata["lowering"].get<std::string>();
  EXPECT_SAYS(why, "the operator RFFT2D (number 8) is not lowered");
  EXPECT_TRUE((*model)->invoke(zero_inputs(**model)));
}

}  // namespace lowering_models_test
}  // namespace weir::engine_test
