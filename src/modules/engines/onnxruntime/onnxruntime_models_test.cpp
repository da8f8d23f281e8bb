// Tests real ONNX models against ../shared/MANIFEST.md and published results.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>

#include "engine_test_support.hpp"
#include "says.hpp"

namespace weir::engine_test {
namespace onnxruntime_models_test {

class OnnxRuntimeModels : public EngineTest {};

// Sizes for the open dimensions of the models, by name.
const std::map<std::string, int64_t> kSizes{{"n", 2},      {"N", 2},   {"batch", 1}, {"h", 40},
                                            {"w", 50},     {"M1", 40}, {"M2", 50},   {"height", 64},
                                            {"width", 96}, {"1", 1}};

TEST_F(OnnxRuntimeModels, AllOpenWithTheListedTensorsAndRun) {
  const auto paths = shared_files("models", ".onnx");
  if (paths.empty()) GTEST_SKIP() << "../shared/models is not there";
  for (const auto& path : paths) {
    SCOPED_TRACE(path);
    const auto listed = listed_model(path.substr(path.find("/models/") + 1));
    ASSERT_FALSE(listed.inputs.empty());
    const auto model = opened(path);
    ASSERT_NE(model, nullptr);
    ASSERT_EQ(model->inputs().size(), listed.inputs.size());
    ASSERT_EQ(model->outputs().size(), listed.outputs.size());
    std::vector<TestTensor> inputs;
    for (size_t i = 0; i < listed.inputs.size(); ++i) {
      const auto info = model->inputs()[i];
      EXPECT_EQ(info.name, listed.inputs[i].name);
      EXPECT_EQ(to_string(info), listed.inputs[i].text());
      std::vector<int64_t> shape;
      for (const auto& extent : listed.inputs[i].shape)
        shape.push_back(kSizes.contains(extent) ? kSizes.at(extent) : std::stoll(extent));
      inputs.push_back(make_tensor(info.type, shape));
    }
    const auto outputs = model->invoke(inputs);
    ASSERT_TRUE(outputs) << outputs.error().message();
    EXPECT_EQ(model->engine_allocated(), 0u);
    for (size_t i = 0; i < listed.outputs.size(); ++i) {
      EXPECT_EQ(model->outputs()[i].name, listed.outputs[i].name);
      const auto expected = listed.outputs[i].text(kSizes);
      if (expected.find("-1") == std::string::npos)
        EXPECT_EQ(to_string((*outputs)[i].info), expected);
      else
        EXPECT_LACKS(to_string((*outputs)[i].info), "-1");
    }
  }
}

// The model's 200 weights are also graph inputs, and ONNX Runtime warns about each.
TEST_F(OnnxRuntimeModels, WarningsAboutEachWeightAreCombined) {
  const auto path = shared_file("models/face/ultraface_RFB-320.onnx");
  if (path.empty()) GTEST_SKIP() << "../shared/models/face is not there";
  take_log();
  ASSERT_NE(opened(path), nullptr);
  const auto lines = take_log();
  ASSERT_EQ(lines.size(), 2u) << lines.size() << " lines, the first: " << lines[0];
  EXPECT_SAYS(lines[0], "appears in graph inputs");
  EXPECT_SAYS(lines[1], " more of this kind");
}

TEST_F(OnnxRuntimeModels, MnistReadsTheNine) {
  const auto model_path = shared_file("models/classification/mnist.onnx");
  if (model_path.empty()) GTEST_SKIP() << "../shared/models/classification/mnist.onnx is not there";
  const auto model = opened(model_path);
  ASSERT_NE(model, nullptr);
  const auto pixels = read_png(shared_file("media/image/9.png"));
  ASSERT_EQ(pixels.size(), 28u * 28u);
  const auto out = model->invoke({make_tensor<float>(WEIR_FLOAT32, {1, 1, 28, 28}, pixels)});
  ASSERT_TRUE(out) << out.error().message();
  EXPECT_EQ(argmax((*out)[0].values<float>()), 9u);
}

// MANIFEST: P-Net's map is ceil((H-2)/2) - 4 high; the same rule gives the width.
TEST_F(OnnxRuntimeModels, PnetFollowsTheSizeOfThePicture) {
  const auto path = shared_file("models/face/mtcnn/onnx/pnet.onnx");
  if (path.empty()) GTEST_SKIP() << "../shared/models/face/mtcnn/onnx/pnet.onnx is not there";
  const auto model = opened(path);
  ASSERT_NE(model, nullptr);
  for (const auto& [h, w] : std::vector<std::pair<int64_t, int64_t>>{
           {12, 12}, {13, 17}, {37, 51}, {64, 64}, {77, 201}, {135, 240}}) {
    const auto map = [](int64_t side) { return (side - 2 + 1) / 2 - 4; };
    const auto out = model->resolve({make_tensor(WEIR_FLOAT32, {1, 3, h, w}).info});
    ASSERT_TRUE(out) << out.error().message();
    EXPECT_EQ(to_shape((*out)[0]), (std::vector<int64_t>{1, 2, map(h), map(w)}));
    EXPECT_EQ(to_shape((*out)[1]), (std::vector<int64_t>{1, 4, map(h), map(w)}));
    const auto run = model->invoke({make_tensor(WEIR_FLOAT32, {1, 3, h, w})});
    ASSERT_TRUE(run) << run.error().message();
    const auto p = (*run)[0].values<float>();
    EXPECT_NEAR(p.front() + p[static_cast<size_t>(map(h) * map(w))], 1, 1e-5);  // softmax
  }
}

TEST_F(OnnxRuntimeModels, PnetRejectsAPictureThatIsTooSmall) {
  const auto path = shared_file("models/face/mtcnn/onnx/pnet.onnx");
  if (path.empty()) GTEST_SKIP() << "../shared/models/face/mtcnn/onnx/pnet.onnx is not there";
  const auto model = opened(path);
  ASSERT_NE(model, nullptr);
  const auto run = model->invoke({make_tensor(WEIR_FLOAT32, {1, 3, 4, 4})});
  ASSERT_FALSE(run);
  EXPECT_FALSE(run.error().what.empty());
}

// The same weights in two layouts: NHWC takes the transposed picture (MANIFEST, MTCNN facts).
TEST_F(OnnxRuntimeModels, TwoExportsOfRnetAgree) {
  const auto nchw = shared_file("models/face/mtcnn/onnx/rnet.onnx");
  const auto nhwc = shared_file("models/face/mtcnn/onnx_nhwc/rnet.onnx");
  if (nchw.empty() || nhwc.empty()) GTEST_SKIP() << "../shared/models/face/mtcnn is not there";
  const auto a = opened(nchw), b = opened(nhwc);
  ASSERT_TRUE(a && b);
  std::vector<float> planar(3 * 24 * 24), packed(planar.size());
  for (size_t c = 0; c < 3; ++c)
    for (size_t y = 0; y < 24; ++y)
      for (size_t x = 0; x < 24; ++x) {
        const float value = std::sin(static_cast<float>(c * 7 + y * 3 + x)) * 0.9f;
        planar[(c * 24 + y) * 24 + x] = value;
        packed[(x * 24 + y) * 3 + c] = value;
      }
  const auto out_a = a->invoke({make_tensor<float>(WEIR_FLOAT32, {1, 3, 24, 24}, planar)});
  const auto out_b = b->invoke({make_tensor<float>(WEIR_FLOAT32, {1, 24, 24, 3}, packed)});
  ASSERT_TRUE(out_a && out_b);
  const auto p_a = (*out_a)[0].values<float>(), p_b = (*out_b)[1].values<float>();
  for (size_t i = 0; i < 2; ++i) EXPECT_NEAR(p_a[i], p_b[i], 1e-5);
}

// MANIFEST: classifies 98.11 % of every 4th labelled row correctly.
TEST_F(OnnxRuntimeModels, PointHistoryAgreesWithTheLabels) {
  const auto path = shared_file("models/sensor/point_history_classifier_lstm.onnx");
  const auto rows = read_csv(shared_file("media/sensor/point_history.csv"));
  if (path.empty() || rows.empty()) GTEST_SKIP() << "../shared/models/sensor is not there";
  const auto model = opened(path);
  ASSERT_NE(model, nullptr);
  std::vector<float> values;
  std::vector<int64_t> labels;
  for (size_t i = 0; i < rows.size(); i += 4) {
    ASSERT_EQ(rows[i].size(), 33u);
    labels.push_back(static_cast<int64_t>(rows[i][0]));
    values.insert(values.end(), rows[i].begin() + 1, rows[i].end());
  }
  const auto count = static_cast<int64_t>(labels.size());
  const auto out = model->invoke({make_tensor<float>(WEIR_FLOAT32, {count, 32}, values),
                                  make_tensor<float>(WEIR_FLOAT32, {}, {0.5f})});
  ASSERT_TRUE(out) << out.error().message();
  const auto ids = (*out)[0].values<int64_t>();
  double right = 0;
  for (size_t i = 0; i < labels.size(); ++i) right += ids[i] == labels[i];
  EXPECT_NEAR(100 * right / static_cast<double>(count), 98.11, 0.1);
}

TEST_F(OnnxRuntimeModels, PointHistoryAcceptsAScalarAsItsSecondInput) {
  const auto path = shared_file("models/sensor/point_history_classifier_lstm.onnx");
  if (path.empty()) GTEST_SKIP() << path << " is not there";
  const auto model = opened(path);
  ASSERT_NE(model, nullptr);
  EXPECT_EQ(model->inputs()[1].rank, 0u);
  const auto rows = make_tensor(WEIR_FLOAT32, {3, 32});
  const auto out = model->invoke({rows, make_tensor<float>(WEIR_FLOAT32, {}, {0.5f})});
  ASSERT_TRUE(out) << out.error().message();
  EXPECT_EQ(to_string((*out)[0].info), "int64[3]");
  for (const auto id : (*out)[0].values<int64_t>()) EXPECT_TRUE(id >= 0 && id < 4) << id;
  // A rank-1 tensor of one element is not a scalar.
  EXPECT_FALSE(model->invoke({rows, make_tensor<float>(WEIR_FLOAT32, {1}, {0.5f})}));
}

}  // namespace onnxruntime_models_test
}  // namespace weir::engine_test
