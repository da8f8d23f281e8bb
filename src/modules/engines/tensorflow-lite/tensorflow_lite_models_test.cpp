// Tests real TensorFlow Lite models against ../shared/MANIFEST.md and labelled data.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>
#include <nlohmann/json.hpp>

#include "engine_test_support.hpp"
#include "says.hpp"
#include "usable_cores.hpp"

namespace weir::engine_test {
namespace tensorflow_lite_models_test {

class TensorflowLiteModels : public EngineTest {};

constexpr int32_t kSoundRate = 16000;

TEST_F(TensorflowLiteModels, AllOpenWithTheListedTensorsAndRun) {
  const auto paths = shared_files("models", ".tflite");
  if (paths.empty()) GTEST_SKIP() << "../shared/models is not there";
  for (const auto& path : paths) {
    SCOPED_TRACE(path);
    const auto listed = listed_model(path.substr(path.find("/models/") + 1));
    ASSERT_FALSE(listed.inputs.empty());
    const auto model = opened(path);
    ASSERT_NE(model, nullptr);
    // The manifest truncates very long lists.
    ASSERT_GE(model->inputs().size(), listed.inputs.size());
    ASSERT_GE(model->outputs().size(), listed.outputs.size());
    for (size_t i = 0; i < listed.inputs.size(); ++i) {
      EXPECT_EQ(model->inputs()[i].name, listed.inputs[i].name);
      EXPECT_EQ(model->inputs()[i].rank, listed.inputs[i].shape.size());
    }
    auto inputs = zero_inputs(*model);
    for (auto& input : inputs)  // speech commands: the sample rate is an input tensor
      if (input.info.type == WEIR_INT32 && input.bytes.size() == sizeof kSoundRate)
        std::memcpy(input.bytes.data(), &kSoundRate, sizeof kSoundRate);
    const auto outputs = model->invoke(inputs);
    ASSERT_TRUE(outputs) << outputs.error().message();
    for (const auto& output : *outputs) EXPECT_LACKS(to_string(output.info), "-1");
  }
}

// 41 and 726 million multiplications.
TEST_F(TensorflowLiteModels, LargeModelsUseSeveralThreads) {
  const std::pair<const char*, int> cases[] = {
      {"models/classification/mobilenet_v1_0.25_224_float.tflite", 1},
      {"models/segmentation/deeplabv3_257_mv_gpu.tflite", 14},
      {"models/classification/mobilenet_v2_1.0_224_quant.tflite",
       1}};  // uint8 does not run in XNNPACK
  for (const auto& [file, max] : cases) {
    const auto path = shared_file(file);
    if (path.empty()) GTEST_SKIP() << file << " is not there";
    EXPECT_EQ(opened(path)->execution().threads,
              static_cast<uint32_t>(std::min(max, usable_cores())))
        << file;
  }
}

TEST_F(TensorflowLiteModels, Uint8ModelsUseXnnpackOnlyWhenAsked) {
  const auto path = shared_file("models/classification/mobilenet_v2_1.0_224_quant.tflite");
  if (path.empty()) GTEST_SKIP() << "MobileNet v2 is not there";
  for (const auto& [options, used] :
       {std::pair<Options, bool>{{}, false}, {{{"Delegate", "XNNPACK"}}, true}})
    EXPECT_EQ(nlohmann::json::parse(opened(path, options)->info().metadata_json)["xnnpack"], used);
}

// The fraction of labelled rows that the model classifies correctly.
double share_right(OpenEngine* model, const std::vector<std::vector<float>>& rows, size_t step) {
  double right = 0, count = 0;
  for (size_t i = 0; i < rows.size(); i += step) {
    const std::vector<float> values(rows[i].begin() + 1, rows[i].end());
    const auto out = model->invoke(
        {make_tensor<float>(WEIR_FLOAT32, {1, static_cast<int64_t>(values.size())}, values)});
    if (!out) return 0;
    right += argmax((*out)[0].values<float>()) == static_cast<size_t>(rows[i][0]);
    ++count;
  }
  return 100 * right / count;
}

// MANIFEST: 96.19 % of 5296 and 96.52 % of 4450 labelled rows.
TEST_F(TensorflowLiteModels, AgreeWithLabelledGestures) {
  const std::tuple<const char*, const char*, double> lines[] = {
      {"models/sensor/point_history_classifier.tflite", "media/sensor/point_history.csv", 96.19},
      {"models/sensor/keypoint_classifier.tflite", "media/sensor/keypoint.csv", 96.52}};
  for (const auto& [path, data, expected] : lines) {
    const auto rows = read_csv(shared_file(data));
    if (shared_file(path).empty() || rows.empty())
      GTEST_SKIP() << "../shared/" << path << " is not there";
    const auto model = opened(shared_file(path));
    ASSERT_NE(model, nullptr);
    EXPECT_NEAR(share_right(model.get(), rows, 1), expected, 0.2) << path;
  }
}

// Expected values: the metadata as read with Python's struct and unzip.
TEST_F(TensorflowLiteModels, ReportTheirPictureAndLabels) {
  const auto path = shared_file("models/classification/mobilenet_v1_0.75_192_quant.tflite");
  if (path.empty()) GTEST_SKIP() << "../shared/models/classification is not there";
  const auto model = opened(path);
  ASSERT_NE(model, nullptr);
  const auto reported = nlohmann::json::parse(model->info().metadata_json)["custom_metadata_map"];
  EXPECT_EQ(reported["tflite.color_space"], "RGB");
  EXPECT_EQ(reported["tflite.mean"], "127.5");
  EXPECT_EQ(reported["tflite.std"], "127.5");
  const auto labels = reported["tflite.labels"].get<std::string>();
  EXPECT_EQ(labels.size(), 21686u);
  EXPECT_EQ(labels.substr(0, 11), "background\n");
}

// MANIFEST, MTCNN facts: any size works; P-Net's map is ceil((H-2)/2) - 4 high.
TEST_F(TensorflowLiteModels, PnetFollowsTheSizeOfThePicture) {
  const auto path = shared_file("models/face/mtcnn/tflite/pnet.tflite");
  if (path.empty()) GTEST_SKIP() << "../shared/models/face/mtcnn is not there";
  const auto model = opened(path);
  ASSERT_NE(model, nullptr);
  const auto map = [](int64_t side) { return (side - 2 + 1) / 2 - 4; };
  for (const auto& [h, w] :
       std::vector<std::pair<int64_t, int64_t>>{{12, 12}, {37, 51}, {135, 240}}) {
    const auto out = model->resolve({make_tensor(WEIR_FLOAT32, {1, h, w, 3}).info});
    ASSERT_TRUE(out) << out.error().message();
    for (const auto& info : *out) {
      EXPECT_EQ(info.shape[1], map(h));
      EXPECT_EQ(info.shape[2], map(w));
    }
  }
}

}  // namespace tensorflow_lite_models_test
}  // namespace weir::engine_test
