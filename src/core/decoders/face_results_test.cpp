// Tests of faces: tensors are encoded from the published descriptions of YuNet and UltraFace.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>

#include "core/decoders/results_test_support.hpp"

namespace weir::decoders {
namespace face_results_test {

struct Face {
  float x, y, width, height;        // centre and size in pixels
  std::vector<float> points;        // x, y of five points
  float class_score, object_score;  // of YuNet
};

// The outputs of YuNet for a picture: classes, objectness, boxes and points of three grids.
class YunetOutputs {
 public:
  YunetOutputs(uint32_t width, uint32_t height) {
    for (const size_t values : {1u, 1u, 4u, 10u})
      for (const uint32_t stride : {8u, 16u, 32u}) {
        columns_[stride] = width / stride;
        cells_[stride] = size_t{width / stride} * (height / stride);
        values_.push_back(std::vector<float>(cells_[stride] * values));
      }
  }
  void add(const Face& face, uint32_t stride) {
    const auto s = static_cast<float>(stride);
    const float column = std::floor(face.x / s), row = std::floor(face.y / s);
    const size_t cell = static_cast<size_t>(row) * columns_[stride] + static_cast<size_t>(column);
    const size_t grid = stride == 8 ? 0 : stride == 16 ? 1 : 2;
    values_[grid][cell] = face.class_score;
    values_[3 + grid][cell] = face.object_score;
    const float box[]{face.x / s - column, face.y / s - row, std::log(face.width / s),
                      std::log(face.height / s)};
    std::copy(box, box + 4, values_[6 + grid].begin() + static_cast<ptrdiff_t>(4 * cell));
    for (size_t i = 0; i < 10; ++i)
      values_[9 + grid][10 * cell + i] = face.points[i] / s - (i % 2 == 0 ? column : row);
  }
  void fill(float value) {
    for (auto& values : values_) std::fill(values.begin(), values.end(), value);
  }
  std::vector<TestTensor> tensors() const {
    std::vector<TestTensor> out;
    const uint32_t strides[]{8, 16, 32};
    const size_t sizes[]{1, 1, 4, 10};
    for (size_t i = 0; i < values_.size(); ++i)
      out.emplace_back(
          std::to_string(sizes[i / 3]) + ":" + std::to_string(cells_.at(strides[i % 3])) + ":1",
          values_[i]);
    return out;
  }

 private:
  std::map<uint32_t, size_t> columns_, cells_;
  std::vector<std::vector<float>> values_;
};

const TestModel kYunetModel{.path = "/models/yunet.onnx",
                            .input = "96:64:3:1",
                            .names = {"cls_8", "cls_16", "cls_32", "obj_8", "obj_16", "obj_32",
                                      "bbox_8", "bbox_16", "bbox_32", "kps_8", "kps_16", "kps_32"}};
const std::vector<Face> kFaces{
    {20, 30, 10, 14, {17, 28, 23, 28, 20, 31, 18, 34, 22, 34}, 0.9f, 0.8f},
    {70, 40, 30, 44, {62, 30, 78, 31, 70, 41, 64, 50, 77, 52}, 1, 0.81f}};

TEST(FaceResults, YunetFacesComeWithFivePoints) {
  YunetOutputs outputs(96, 64);
  outputs.add(kFaces[0], 8);
  outputs.add(kFaces[1], 32);
  ResultsRun run("detection", {});
  ASSERT_TRUE(run.configure(outputs.tensors(), &kYunetModel)) << run.error;
  run.decode(outputs.tensors());
  ASSERT_EQ(run.n_rows(), 2u) << run.error;
  const size_t order[]{1, 0};  // scores 0.9 and 0.8485
  for (size_t i = 0; i < 2; ++i) {
    const Face& face = kFaces[order[i]];
    const ResultRow row = run.row(i);
    EXPECT_NEAR(row.score(), std::sqrt(face.class_score * face.object_score), 1e-5);
    EXPECT_NEAR(row.box().x1, face.x - face.width / 2, 1e-4);
    EXPECT_NEAR(row.box().y1, face.y - face.height / 2, 1e-4);
    EXPECT_NEAR(row.box().x2, face.x + face.width / 2, 1e-4);
    EXPECT_NEAR(row.box().y2, face.y + face.height / 2, 1e-4);
    ASSERT_EQ(row.n_points(), 5u);
    for (uint32_t p = 0; p < 5; ++p) {
      EXPECT_NEAR(row.x(p), face.points[2 * p], 1e-4);
      EXPECT_NEAR(row.y(p), face.points[2 * p + 1], 1e-4);
    }
  }
}

TEST(FaceResults, YunetOutputsMayComeInAnyOrderWithoutNames) {
  YunetOutputs outputs(96, 64);
  outputs.add(kFaces[0], 8);
  auto tensors = outputs.tensors();
  std::reverse(tensors.begin(), tensors.end());
  const TestModel model{.input = "96:64:3:1"};
  ResultsRun run("pose", {});
  ASSERT_TRUE(run.configure(tensors, &model)) << run.error;
  run.decode(tensors);
  ASSERT_EQ(run.n_rows(), 1u);
  EXPECT_NEAR(run.row(0).box().x1, 15, 1e-4);
}

TEST(FaceResults, YunetNeedsTheSizeOfThePicture) {
  const YunetOutputs outputs(96, 64);
  ResultsRun run("detection", {});
  TestModel open = kYunetModel;
  open.input = "0:0:3:1";
  ASSERT_TRUE(run.configure(outputs.tensors(), &open)) << run.error;
  run.decode(outputs.tensors());
  EXPECT_SAYS(run.error, "the size of the model's input is not known");
  EXPECT_SAYS(run.error, "custom=input:");
  // The source map knows it.
  SourceMap map;
  map.width = 96, map.height = 64;
  run.decode(outputs.tensors(), {map});
  EXPECT_EQ(run.error, "");
  map.width = 192;
  YunetOutputs with_face(96, 64);
  with_face.fill(1);
  run.decode(with_face.tensors(), {map});
  EXPECT_SAYS(run.error, "the YuNet outputs belong to a different picture size");
}

void expect_no_face(const std::vector<TestTensor>& tensors, const TestModel& model,
                    const DecoderOptions& options) {
  ResultsRun run("detection", options);
  ASSERT_TRUE(run.configure(tensors, &model)) << run.error;
  run.decode(tensors);
  ASSERT_EQ(run.n_rows(), 1u) << run.error;
  EXPECT_TRUE(run.row(0).is_background());
}

TEST(FaceResults, YunetIgnoresNumbersThatAreNotFinite) {
  for (const float value : {NAN, INFINITY, -INFINITY}) {
    YunetOutputs outputs(96, 64);
    outputs.fill(value);
    expect_no_face(outputs.tensors(), kYunetModel, {});
  }
}

TEST(FaceResults, YunetAHundredThousandCandidates) {
  YunetOutputs outputs(2592, 2592);
  outputs.fill(1);
  TestModel model = kYunetModel;
  model.input = "2592:2592:3:1";
  ResultsRun run("detection", {{"max-results", "10"}});
  ASSERT_TRUE(run.configure(outputs.tensors(), &model)) << run.error;
  run.decode(outputs.tensors());
  EXPECT_EQ(run.n_rows(), 10u);
}

// UltraFace for a picture of 320 x 240: 3 priors in 40 x 30 cells, 2 in 20 x 15, 2 in 10 x 8,
// 3 in 5 x 4.
constexpr size_t kPriors = 4420;

struct UltrafaceTensors {
  std::vector<float> scores = std::vector<float>(2 * kPriors),
                     boxes = std::vector<float>(4 * kPriors);
  std::vector<TestTensor> tensors(bool scores_first = true) const {
    std::vector<TestTensor> out{TestTensor("2:4420:1", scores), TestTensor("4:4420:1", boxes)};
    if (!scores_first) std::swap(out[0], out[1]);
    return out;
  }
};
const TestModel kUltrafaceModel{
    .path = "/models/ultra.onnx", .input = "320:240:3:1", .names = {"scores", "boxes"}};

TEST(FaceResults, UltrafaceBoxesArePartsOfThePictureOrInPixels) {
  for (const std::vector<float>& box :
       {std::vector<float>{0.25f, 0.5f, 0.5f, 0.75f}, std::vector<float>{80, 120, 160, 180}}) {
    UltrafaceTensors outputs;
    outputs.scores[2 * 77] = 0.1f, outputs.scores[2 * 77 + 1] = 0.9f;
    std::copy(box.begin(), box.end(), outputs.boxes.begin() + 4 * 77);
    ResultsRun run("detection", {});
    ASSERT_TRUE(run.configure(outputs.tensors(), &kUltrafaceModel)) << run.error;
    run.decode(outputs.tensors());
    ASSERT_EQ(run.n_rows(), 1u) << run.error;
    EXPECT_EQ(run.row(0).box(), (Box{80, 120, 160, 180}));
    EXPECT_EQ(run.row(0).score(), 0.9f);
  }
}

// Encodes a box relative to a prior with these values.
void encode(std::vector<float>* boxes, size_t index, Box box, float prior_x, float prior_y,
            float side) {
  const float prior_width = std::min(1.0f, side / 320), prior_height = std::min(1.0f, side / 240);
  const float x = (box.x1 + box.x2) / 2 / 320, y = (box.y1 + box.y2) / 2 / 240;
  const float values[]{(x - prior_x / 320) / (0.1f * prior_width),
                       (y - prior_y / 240) / (0.1f * prior_height),
                       std::log(box.width() / 320 / prior_width) / 0.2f,
                       std::log(box.height() / 240 / prior_height) / 0.2f};
  std::copy(values, values + 4, boxes->begin() + static_cast<ptrdiff_t>(4 * index));
}

TEST(FaceResults, UltrafaceRawBoxesAreRelativeToPriors) {
  struct Case {
    size_t index;
    float x, y, side;  // of the prior
    Box box;
  };
  // Cell (3, 2) of 8 pixels, second side; cell (19, 14) of 16, first side; cell (9, 7) of 32,
  // second side, beyond the lower edge and clamped; cell (4, 0) of 64, third side.
  const std::vector<Case> cases{
      {(2 * 40 + 3) * 3 + 1, 28, 20, 16, {10, 5, 40, 45}},
      {3600 + (14 * 20 + 19) * 2, 312, 232, 32, {280, 200, 318, 236}},
      {3600 + 600 + (7 * 10 + 9) * 2 + 1, 304, 240, 96, {200, 90, 300, 180}},
      {3600 + 600 + 160 + 4 * 3 + 2, 288, 32, 256, {150, 60, 180, 99}}};
  for (const auto& test : cases) {
    UltrafaceTensors outputs;
    outputs.scores[2 * test.index + 1] = 1;
    encode(&outputs.boxes, test.index, test.box, test.x, test.y, test.side);
    const TestModel model{.input = "3:320:240:1"};
    ResultsRun run("detection", {{"head", "ultraface-raw"}});
    ASSERT_TRUE(run.configure(outputs.tensors(false), &model)) << run.error;
    run.decode(outputs.tensors(false));
    ASSERT_EQ(run.n_rows(), 1u) << run.error;
    EXPECT_NEAR(run.row(0).box().x1, test.box.x1, 0.01) << test.index;
    EXPECT_NEAR(run.row(0).box().y1, test.box.y1, 0.01) << test.index;
    EXPECT_NEAR(run.row(0).box().x2, test.box.x2, 0.01) << test.index;
    EXPECT_NEAR(run.row(0).box().y2, test.box.y2, 0.01) << test.index;
  }
}

TEST(FaceResults, UltrafaceWithoutNamesFitsTwoHeads) {
  const TestModel model{.input = "3:320:240:1"};
  ResultsRun run("detection", {});
  EXPECT_FALSE(run.configure(UltrafaceTensors().tensors(), &model));
  EXPECT_SAYS(run.error, "the outputs fit several heads: ultraface, ultraface-raw");
  EXPECT_SAYS(run.error, "custom=head:ultraface or tensor_decoder custom=head:ultraface-raw");
}

TEST(FaceResults, UltrafaceOfAnotherInputIsRefused) {
  ResultsRun run("detection", {{"head", "ultraface"}});
  const TestModel model{.input = "640:480:3:1"};
  EXPECT_FALSE(run.configure(UltrafaceTensors().tensors(), &model));
  EXPECT_SAYS(run.error, "the outputs are not those of the head ultraface");
  EXPECT_SAYS(run.error, "2 tensors 2:N and 4:N");
}

TEST(FaceResults, UltrafaceIgnoresNumbersThatAreNotFinite) {
  for (const char* head : {"ultraface", "ultraface-raw"}) {
    UltrafaceTensors outputs;
    std::fill(outputs.scores.begin(), outputs.scores.end(), 1.0f);
    std::fill(outputs.boxes.begin(), outputs.boxes.end(), INFINITY);
    outputs.scores[1] = NAN;
    expect_no_face(outputs.tensors(), kUltrafaceModel, {{"head", head}});
  }
}

TEST(FaceResults, UltrafaceIsReadFromQuantisedTensors) {
  std::vector<uint8_t> scores(2 * kPriors), boxes(4 * kPriors);
  scores[2 * 5 + 1] = 240;  // 240 / 256
  boxes[4 * 5] = 64, boxes[4 * 5 + 1] = 32, boxes[4 * 5 + 2] = 128, boxes[4 * 5 + 3] = 96;
  TestModel model = kUltrafaceModel;
  model.scales = {1 / 256.0f, 1 / 128.0f};
  model.zero_points = {0, 0};
  const std::vector<TestTensor> tensors{TestTensor(ElementType::UInt8, "2:4420:1", scores),
                                        TestTensor(ElementType::UInt8, "4:4420:1", boxes)};
  ResultsRun run("detection", {});
  ASSERT_TRUE(run.configure(tensors, &model)) << run.error;
  run.decode(tensors);
  ASSERT_EQ(run.n_rows(), 1u);
  EXPECT_EQ(run.row(0).score(), 0.9375f);
  EXPECT_EQ(run.row(0).box(), (Box{160, 60, 320, 180}));
}

}  // namespace face_results_test
}  // namespace weir::decoders
