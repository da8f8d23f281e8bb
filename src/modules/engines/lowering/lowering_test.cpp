// Tests when lowering is used, what it leaves to TensorFlow Lite, and what it rejects.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lowering/lowering_test_support.hpp"

#include "says.hpp"

namespace weir::engine_test {
namespace lowering_test {

class Lowering : public LoweringTest {};

TEST_F(Lowering, AnOperatorThatIsNotLoweredStaysWithTensorFlowLiteAndIsNamed) {
  const auto model = open(tflite_negation().bytes(), kLowered);
  ASSERT_TRUE(model) << model.error().message();
  const std::string words = logged();
  EXPECT_SAYS(words, "the operator NEG (number 1) is not lowered");
  EXPECT_SAYS(words, "TensorFlow Lite runs it");
  const auto y = (*model)->invoke({make_tensor<float>(WEIR_FLOAT32, {2, 3}, {1, 2, 3, -4, 5, 6})});
  ASSERT_TRUE(y) << y.error().message();
  EXPECT_EQ((*y)[0].values<float>(), (std::vector<float>{-1, -2, -3, 4, -5, -6}));
}

TEST_F(Lowering, IsOffByDefault) {
  for (const auto& options : {Options{}, Options{{"Lowering", "None"}}}) {
    ASSERT_TRUE(open(tflite_negation().bytes(), options));
    EXPECT_LACKS(logged(), "Lowering");
  }
}

TEST_F(Lowering, AnUnknownRunnerIsRejectedWithAMessage) {
  const auto error = get_error(tflite_negation().bytes(), {{"Lowering", "tvm"}});
  EXPECT_EQ(error.code, Code::OPTION_VALUE);
  EXPECT_EQ(error.what, "the option Lowering has a value that cannot be used");
  EXPECT_EQ(error.offered, "Lowering:tvm");
  EXPECT_EQ(error.needed, "onnxruntime or None");
  EXPECT_EQ(error.fix, "custom=Lowering:onnxruntime");
}

TEST_F(Lowering, AMissingOnnxRuntimeIsAnErrorThatNamesIt) {
  let_find("onnxruntime", nullptr);
  const auto error = get_error(tflite_negation().bytes(), kLowered);
  EXPECT_EQ(error.code, Code::ENGINE_UNKNOWN);
  EXPECT_EQ(error.offered, "onnxruntime");
}

TEST_F(Lowering, OnnxRuntimeRunsLoweredModels) {
  const auto path = folder_.write("model.tflite", TfliteBuilder()
                                                      .input("x", kTfInt8, {1, 4})
                                                      .quantized({{0.5f}, {-10}})
                                                      .constant<int32_t>("s", kTfInt32, {2}, {4, 1})
                                                      .output("y", kTfInt8, {4, 1})
                                                      .quantized({{0.5f}, {-10}})
                                                      .node(kOpReshape, {"x", "s"}, {"y"})
                                                      .bytes());
  const auto model = OpenEngine::open(*other_engine(), path);
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_STREQ((*model)->inputs()[0].name, "x");
  const auto y = (*model)->invoke({make_tensor<int8_t>(WEIR_INT8, {1, 4}, {-128, -1, 0, 127})});
  ASSERT_TRUE(y) << y.error().message();
  EXPECT_EQ((*y)[0].values<int8_t>(), (std::vector<int8_t>{-128, -1, 0, 127}));
}

TEST_F(Lowering, OnnxRuntimeReportsTheMetadataOfTheFile) {
  const auto path =
      folder_.write("model.tflite", TfliteBuilder()
                                        .input("x", kTfUint8, {1, 2, 2, 3})
                                        .quantized({{0.25f}, {7}})
                                        .constant<int32_t>("s", kTfInt32, {2}, {1, 12})
                                        .output("y", kTfUint8, {1, 12})
                                        .quantized({{0.25f}, {7}})
                                        .node(kOpReshape, {"x", "s"}, {"y"})
                                        .bytes());
  const auto model = OpenEngine::open(*other_engine(), path);
  ASSERT_TRUE(model) << model.error().message();
  for (const auto& info : {(*model)->inputs()[0], (*model)->outputs()[0]}) {
    EXPECT_EQ(info.scale, 0.25f);
    EXPECT_EQ(info.zero_point, 7);
  }
  EXPECT_EQ((*model)->inputs()[0].layout, uint32_t{WEIR_LAYOUT_NHWC});
  EXPECT_SAYS(std::string((*model)->info().metadata_json), R"("lowering":"onnxruntime")");
}

// Both engines recognise the file; the one for which it was made scores higher.
TEST_F(Lowering, BothEnginesClaimTheFile) {
  const auto bytes = tflite_negation().bytes();
  const auto score = [&](const weir_engine& engine) {
    int out = -1;
    weir_error error{};
    EXPECT_GE(engine.probe("model.bin", bytes.data(), bytes.size(), &out, &error), 0);
    return out;
  };
  EXPECT_GT(score(*other_engine()), 0);
  EXPECT_GT(score(*engine()), score(*other_engine()));
}

TEST_F(Lowering, OnnxRuntimeRejectsAndNamesOperatorsThatAreNotLowered) {
  const auto path = folder_.write("model.tflite", tflite_negation().bytes());
  const auto model = OpenEngine::open(*other_engine(), path);
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().code, Code::MODEL_UNSUPPORTED);
  EXPECT_EQ(model.error().what, "the operator NEG (number 1) is not lowered to ONNX Runtime");
  EXPECT_EQ(model.error().offered, path);
  EXPECT_EQ(model.error().fix, "framework=tensorflow-lite");
}

TEST_F(Lowering, ADamagedFileIsRejectedAsWithoutLowering) {
  auto bytes = tflite_negation().bytes();
  bytes.resize(bytes.size() / 2);
  const auto error = get_error(bytes, kLowered);
  EXPECT_EQ(error.code, Code::MODEL_INVALID);
  EXPECT_SAYS(error.offered, "model.bin");
}

}  // namespace lowering_test
}  // namespace weir::engine_test
