// Tests of tensor_to_roi and tensor_from_roi beside GStreamer's own elements for analytics.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>
#include <fstream>

#include "elements/tests/pipeline_test_support.hpp"
#include "onnxruntime/onnx_builder_test_support.hpp"

namespace weir {
namespace analytics_elements_test {

using namespace weir::test;
using Floats = std::vector<float>;

// Pictures of 64 * 48 from `source`; tensor_to_roi finds a box in each of them.
std::string found_in(const std::string& source, const Floats& box) {
  std::string numbers;
  for (size_t i = 0; i < 4; ++i)
    numbers += ",add:" + std::to_string(box[i]) + "@" + std::to_string(i);
  return source +
         " num-buffers=2 ! video/x-raw,format=RGB,width=64,height=48,framerate=10/1 ! tee name=t ! "
         "queue ! tensor_to_roi name=r t. ! queue ! tensor_preprocess width=4 height=1 "
         "channel-order=GRAY type=float32 layout=NCHW ! tensor_transform mode=arithmetic "
         "option=per-channel:true@0,mul:0@0,mul:0@1,mul:0@2,mul:0@3" +
         numbers + " ! r.results r. ! ";
}
bool has_element(const char* name) {
  return static_cast<bool>(Ref<GstElementFactory>::adopt(gst_element_factory_find(name)));
}

// videoscale keeps the rectangle of a region alone, which is still that of the object.
TEST(AnalyticsElements, MetadataFollowsAScaledPicture) {
  PlayedPipeline p(found_in("videotestsrc", {8.25f, 12.5f, 32.5f, 36.75f}) +
                   "videoconvertscale ! video/x-raw,width=1280,height=960 ! tensor_from_roi ! "
                   "tensor_sink name=out");
  p.watch("out");
  ASSERT_EQ(p.plays_to_its_end(), "");
  const auto seen = p.seen<uint8_t>("out");
  ASSERT_EQ(seen.size(), 2u);
  ASSERT_EQ(seen[0].size(), 128 + 9 * sizeof(float));
  Floats row(9);
  std::memcpy(row.data(), seen[0].data() + 128, 9 * sizeof(float));
  EXPECT_EQ(row, (Floats{160, 240, 660, 740, 1, 0, 0, -1, 0}));  // 20 times 8, 12, 33, 37
}

TEST(AnalyticsElements, ObjectdetectionoverlayDrawsOurObjects) {
  if (!has_element("objectdetectionoverlay"))
    GTEST_SKIP() << "objectdetectionoverlay is not installed";
  PlayedPipeline p(
      found_in("videotestsrc pattern=black", {8, 12, 32, 36}) +
      "objectdetectionoverlay draw-labels=false object-detection-outline-color=4294901760 ! "
      "videoconvertscale ! video/x-raw,format=RGB ! tensor_converter ! tensor_sink name=out");
  p.watch("out");
  ASSERT_EQ(p.plays_to_its_end(), "");
  for (const auto& picture : p.seen<uint8_t>("out")) {
    ASSERT_EQ(picture.size(), 64u * 48 * 3);
    const auto red = [&](size_t x, size_t y) { return picture[(y * 64 + x) * 3]; };
    for (const auto& [x, y] : {std::pair{8, 24}, {32, 24}, {20, 12}, {20, 36}})
      EXPECT_GT(red(static_cast<size_t>(x), static_cast<size_t>(y)), 100) << x << "," << y;
    EXPECT_EQ(red(20, 24), 0);
    EXPECT_EQ(red(50, 24), 0);
  }
}

// A model with the outputs of detectors of the TensorFlow Object Detection API, always the same.
std::string write_detector() {
  const std::string path = testing::TempDir() + "weir-analytics-detector.onnx";
  engine_test::OnnxBuilder model;
  model.input("image", engine_test::kUint8, {"1", "48", "64", "3"})
      .constant("boxes", {1, 2, 4}, {0.25f, 0.125f, 0.75f, 0.5f, 0, 0, 1, 0.25f})
      .constant("classes", {1, 2}, {1, 0})
      .constant("scores", {1, 2}, {0.75f, 0.5f})
      .constant("count", {1}, {2});
  for (const auto& [from, to] : {std::pair{"boxes", "detection_boxes"},
                                 {"classes", "detection_classes"},
                                 {"scores", "detection_scores"},
                                 {"count", "num_detections"}})
    model.node("Identity", {from}, {to});
  model.output("detection_boxes", engine_test::kFloat, {"1", "2", "4"})
      .output("detection_classes", engine_test::kFloat, {"1", "2"})
      .output("detection_scores", engine_test::kFloat, {"1", "2"})
      .output("num_detections", engine_test::kFloat, {"1"});
  const auto bytes = model.bytes();
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  return path;
}

TEST(AnalyticsElements, WhatSsdobjectdetectorFindsIsRead) {
  if (!has_element("onnxinference") || !has_element("ssdobjectdetector"))
    GTEST_SKIP() << "onnxinference or ssdobjectdetector is not installed";
  const std::string labels = testing::TempDir() + "weir-analytics-detector.txt";
  std::ofstream(labels) << "cat\ndog\n";
  PlayedPipeline p(
      "videotestsrc num-buffers=2 ! video/x-raw,format=RGB,width=64,height=48,framerate=10/1 ! "
      "onnxinference model-file=" +
      write_detector() + " ! ssdobjectdetector label-file=" + labels +
      " ! tensor_from_roi labels=" + labels + " ! tensor_sink name=out");
  p.watch("out");
  ASSERT_EQ(p.plays_to_its_end(), "");
  const auto seen = p.seen<uint8_t>("out");
  ASSERT_EQ(seen.size(), 2u);
  Floats rows(18);
  ASSERT_EQ(seen[1].size(), 128 + 18 * sizeof(float));
  std::memcpy(rows.data(), seen[1].data() + 128, 18 * sizeof(float));
  EXPECT_EQ(rows, (Floats{8, 12, 32, 36, 0.75f, 1, 0, -1, 0, 0, 0, 16, 48, 0.5f, 0, 0, -1, 0}));
}

}  // namespace analytics_elements_test
}  // namespace weir
