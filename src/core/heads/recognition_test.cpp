// Tests of which family is recognised by what is known of a model, and of the errors where two fit.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/head_test_support.hpp"
#include "core/heads/readings.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::heads {
namespace recognition_test {

constexpr Size k640{640, 640};

TestOutput zeros(const char* shape, const char* name = "") {
  return TestOutput(shape, Floats(static_cast<size_t>(Shape::parse(shape).count().value_or(0))),
                    name);
}
std::string family(const std::vector<TestOutput>& outputs, size_t labels = 0,
                   uint32_t tasks = kDetection, std::map<std::string, std::string> metadata = {}) {
  return recognised(
      outputs, {.tasks = tasks, .input = k640, .labels = labels, .metadata = std::move(metadata)});
}

TEST(Recognition, KnowsTheUsualExports) {
  EXPECT_EQ(family({zeros("8400:84:1")}), "yolov8");
  EXPECT_EQ(family({zeros("84:8400:1")}), "yolov8");
  EXPECT_EQ(family({zeros("8400:7:1")}), "yolov8");
  EXPECT_EQ(family({zeros("8400:20:1")}), "yolov8-obb");  // 15 classes of DOTA
  EXPECT_EQ(family({zeros("8400:19:1")}), "yolov8");
  EXPECT_EQ(family({zeros("85:25200:1")}), "yolov5");
  EXPECT_EQ(family({zeros("85:8400:1")}), "yolox");
  EXPECT_EQ(family({zeros("112:8400:1")}), "nanodet");
  EXPECT_EQ(family({zeros("6:300:1")}), "yolov10");
  EXPECT_EQ(family({zeros("84:300:1")}), "rtdetr");
  EXPECT_EQ(family({zeros("8400:116:1"), zeros("160:160:32:1")}), "yolov8-seg");
  EXPECT_EQ(family({zeros("117:25200:1"), zeros("160:160:32:1")}, 0, kSegmentation), "yolov5-seg");
  EXPECT_EQ(family({zeros("8400:56:1")}, 0, kPose), "yolov8-pose");
  EXPECT_EQ(family({zeros("92:100:1"), zeros("4:100:1")}), "detr");
  EXPECT_EQ(family({zeros("80:300:1"), zeros("4:300:1")}), "rtdetr");
  EXPECT_EQ(family({zeros("80:8400:1"), zeros("4:8400:1")}), "yolo-nas");
  EXPECT_EQ(family({zeros("4:8400:1"), zeros("8400:80:1")}), "yolo-nas");
  EXPECT_EQ(family({zeros("5:100:1"), zeros("100:1", "labels")}), "labels-boxes-scores");
  EXPECT_EQ(family({zeros("40:40:85:1")}), "fastestdet");
  EXPECT_EQ(family({zeros("1000:1")}, 0, kClassification), "classifier");
  EXPECT_EQ(family({zeros("21:257:257:1")}, 0, kSegmentation), "deeplab");
  EXPECT_EQ(family({zeros("256:256:1")}, 0, kDepth), "depth");
}

TEST(Recognition, PicturesAreNotScoresOfThreeClasses) {
  for (const char* shape : {"3:640:640:1", "640:640:3:1", "3:1280:1280:1"}) {
    EXPECT_SAYS(family({zeros(shape)}, 0, kSegmentation), "the output looks like a picture");
    EXPECT_SAYS(family({zeros(shape)}, 0, kSegmentation), "custom=head:deeplab");
    EXPECT_EQ(family({zeros(shape)}, 3, kSegmentation), "deeplab") << "the labels say so";
  }
  EXPECT_EQ(family({zeros("3:160:160:1")}, 0, kSegmentation), "deeplab");
  EXPECT_EQ(family({zeros("4:640:640:1")}, 0, kSegmentation), "deeplab");
}

TEST(Recognition, LabelsDecideBetweenFamilies) {
  EXPECT_EQ(family({zeros("12:8400:1")}, 8), "yolov8");
  EXPECT_EQ(family({zeros("12:8400:1")}, 7), "yolox");
  EXPECT_EQ(family({zeros("85:8400:1")}, 81), "yolov8");
  EXPECT_EQ(family({zeros("8400:20:1")}, 15), "yolov8-obb");
  EXPECT_EQ(family({zeros("8400:20:1")}, 16), "yolov8");
  EXPECT_EQ(family({zeros("8400:56:1")}, 1), "yolov8-pose");
  EXPECT_EQ(family({zeros("8400:56:1")}, 52), "yolov8");
  EXPECT_EQ(family({zeros("12:100:1"), zeros("4:100:1")}, 11), "detr");
  EXPECT_EQ(family({zeros("12:100:1"), zeros("4:100:1")}, 12), "rtdetr");
}

TEST(Recognition, TheTaskInTheMetadataDecides) {
  const auto of_task = [](const char* task) {
    return family({zeros("8400:56:1")}, 0, kDetection, {{"task", task}});
  };
  EXPECT_EQ(of_task("detect"), "yolov8");
  EXPECT_EQ(of_task("pose"), "yolov8-pose");
  EXPECT_EQ(of_task("obb"), "yolov8-obb");
  EXPECT_SAYS(of_task("classify"), "no head of this mode fits these outputs");
}

TEST(Recognition, FewerLabelsThanClassesChangeNothing) {
  EXPECT_EQ(family({zeros("8400:84:1")}, 3), "yolov8");
  EXPECT_EQ(family({zeros("85:25200:1")}, 3), "yolov5");
}

TEST(Recognition, TwoReadingsAreAnErrorThatNamesBoth) {
  // 81 classes, or an objectness and 80.
  const std::string error = family({zeros("8400:85:1")});
  EXPECT_SAYS(error, "the outputs fit several heads: yolov8, yolox");
  EXPECT_SAYS(error, "float32 8400:85");
  EXPECT_SAYS(error, "custom=head:yolov8 or tensor_decoder custom=head:yolox");
  EXPECT_SAYS(family({zeros("12:8400:1")}), "yolov8");
  EXPECT_SAYS(family({zeros("12:8400:1")}), "yolox");
  EXPECT_SAYS(family({zeros("12:100:1"), zeros("4:100:1")}), "detr, rtdetr");
  EXPECT_SAYS(family({zeros("7:100:1")}), "detection-output, yolov7-end2end");
  EXPECT_SAYS(family({zeros("8400:56:1")}), "yolov8, yolov8-pose");
}

TEST(Recognition, APictureThatContradictsTheCellsFitsNothing) {
  const std::string error = recognised({zeros("8400:84:1")}, {.input = {320, 320}, .labels = 80});
  EXPECT_SAYS(error, "no head of this mode fits these outputs");
  EXPECT_SAYS(error, "offered: float32 8400:84:1 of an input of 320 x 320");
  EXPECT_SAYS(error, "yolov8: 1 tensor N:4+CLASSES");
  EXPECT_SAYS(error, "tensor_decoder custom=head:yolov8");
  EXPECT_LT(error.size(), 1000u) << error;
}

TEST(Recognition, OutputsThatNoHeadOpensNameTheHeadsOnly) {
  const std::string error = family({zeros("1000:1"), zeros("3:1")});
  EXPECT_SAYS(error, "needed: the outputs of a head of docs/heads.md: blazeface, ");
  EXPECT_SAYS(error, " others");
  EXPECT_EQ(error.find("fix: "), std::string::npos) << error;
  EXPECT_LT(error.size(), 400u) << error;
}

TEST(Recognition, TheStatedTaskRemovesOtherReadings) {
  const auto read = [](const char* shape, const char* task, const char* name = "") {
    ModelSignature facts;
    facts.input = k640;
    facts.outputs = {{{.type = ElementType::Float32, .shape = Shape::parse(shape), .name = name}}};
    if (task) facts.metadata["task"] = task;
    const auto reading = only_reading(facts);
    return reading ? std::string(reading->family->name) : "";
  };
  EXPECT_EQ(read("640:640:1:1", nullptr), "") << "text, segments or depths";
  EXPECT_EQ(read("640:640:1:1", "segment"), "deeplab");
  EXPECT_EQ(read("640:640:1:1", "Segment"), "deeplab");
  EXPECT_EQ(read("640:640:1:1", "detect"), "");
  EXPECT_EQ(read("640:640:1:1", "of another writer"), "");
  for (const char* task : {"ocr", "text-detection"})
    EXPECT_EQ(read("640:640:1:1", task, "sigmoid_0.tmp_0"), "db") << task;
  EXPECT_EQ(read("640:640:1:1", "segment", "sigmoid_0.tmp_0"), "deeplab");
  EXPECT_EQ(read("8400:56:1", nullptr), "");
  EXPECT_EQ(read("8400:56:1", "detect"), "yolov8");
}

TEST(Recognition, AnotherModeHasOtherFamilies) {
  EXPECT_SAYS(family({zeros("8400:84:1")}, 0, kClassification),
              "no head of this mode fits these outputs");
  EXPECT_SAYS(family({zeros("1000:1")}, 0, kDetection), "needed: ");
}

TEST(Recognition, GridsOfDetectorsAndScoresOfPixelsAreNoHeatMaps) {
  constexpr uint32_t kObjects = kDetection | kPose;
  EXPECT_EQ(family({zeros("40:40:85:1")}, 0, kObjects), "fastestdet");
  EXPECT_EQ(family({zeros("21:640:640:1")}, 0, kPose | kSegmentation), "deeplab");
  EXPECT_EQ(family({zeros("160:160:17:1")}, 0, kPose), "heat-maps");
}

TEST(Recognition, ListsTheFamiliesThatFit) {
  ModelSignature facts;
  facts.input = k640;
  const auto names = [&](const char* shape, uint32_t tasks) {
    facts.outputs = {{{.type = ElementType::Float32, .shape = Shape::parse(shape), .name = {}}}};
    std::vector<std::string> out;
    for (const Family* one : fitting(facts, tasks)) out.emplace_back(one->name);
    return out;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(names("8400:84:1", kDetection), Names{"yolov8"});
  EXPECT_EQ(names("8400:85:1", kDetection), (Names{"yolov8", "yolox"}));
  EXPECT_EQ(names("8400:84:1", kClassification), Names());
  facts.outputs = {{{.type = ElementType::Float32, .shape = {0, 4}, .name = {}}}};
  EXPECT_THROW(fitting(facts, kDetection), Failure);
}

TEST(Recognition, FewMapsAreAskedFor) {
  constexpr uint32_t kMaps = kPose | kSegmentation | kDepth;
  const auto names = [&](const char* shape, size_t labels) {
    ModelSignature facts{.outputs = {zeros(shape).facts}, .input = k640, .metadata = {}};
    facts.labels = labels;
    std::vector<std::string> out;
    for (const auto& reading : likely(list_readings(facts, kMaps), facts))
      out.emplace_back(reading.family->name);
    return out;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(names("160:160:4:1", 0), (Names{"heat-maps", "deeplab"}));
  EXPECT_EQ(names("4:160:160:1", 0), (Names{"heat-maps", "deeplab"}));
  EXPECT_EQ(names("160:160:4:1", 4), (Names{"deeplab"})) << "a label for each map";
  EXPECT_EQ(names("160:160:17:1", 0), (Names{"heat-maps"}));
  EXPECT_EQ(names("160:160:17:1", 17), (Names{"heat-maps", "deeplab"})) << "names of either";
  EXPECT_EQ(names("17:160:160:1", 17), (Names{"heat-maps", "deeplab"}));
  EXPECT_EQ(names("160:160:17:1", 3), (Names{"heat-maps"}));
  EXPECT_EQ(names("160:160:1", 0), (Names{"heat-maps", "deeplab", "depth"}));
}

TEST(Recognition, TheNumberOfMapsDecidesNotTheirSides) {
  constexpr uint32_t kMaps = kPose | kSegmentation;
  const auto names = [&](const std::string& shape, uint32_t side, const char* name = "") {
    const ModelSignature facts{.outputs = {zeros(shape.c_str(), name).facts},
                               .input = {4 * side, 4 * side},
                               .metadata = {}};
    std::vector<std::string> out;
    for (const auto& reading : likely(list_readings(facts, kMaps), facts))
      out.emplace_back(reading.family->name);
    return out;
  };
  using Names = std::vector<std::string>;
  for (const uint32_t side : {16u, 17u, 21u}) {
    const std::string sides = std::to_string(side) + ":" + std::to_string(side);
    EXPECT_EQ(names(sides + ":4:1", side), (Names{"heat-maps", "deeplab"})) << side;
    EXPECT_EQ(names("4:" + sides + ":1", side), (Names{"heat-maps", "deeplab"})) << side;
    EXPECT_EQ(names(sides + ":4:1", side, "heatmaps"), (Names{"heat-maps"})) << side;
    EXPECT_EQ(names(sides + ":4:1", side, "keypoint_maps"), (Names{"heat-maps"})) << side;
    for (const char* points : {"5", "15", "17", "20", "29"})
      EXPECT_EQ(names(sides + ":" + points + ":1", side), (Names{"heat-maps"})) << points;
    EXPECT_GT(names(sides + ":1:1", side, "heatmap").size(), 1u) << "of what draws attention, say";
  }
}

TEST(Recognition, AMapOfTheInputsSizeIsNoHeatMap) {
  constexpr uint32_t kAll = ~0u;
  EXPECT_EQ(family({zeros("640:640:1", "predicted_depth")}, 0, kAll), "depth");
  EXPECT_EQ(family({zeros("640:640:1", "sigmoid_0.tmp_0")}, 0, kAll), "db");
  EXPECT_SAYS(family({zeros("640:640:1", "block/depthwise")}, 0, kAll), "db, deeplab, depth");
  EXPECT_SAYS(family({zeros("640:640:1")}, 0, kPose), "no head of this mode");
  EXPECT_EQ(family({zeros("160:160:1")}, 0, kPose), "heat-maps");
}

}  // namespace recognition_test
}  // namespace weir::heads
