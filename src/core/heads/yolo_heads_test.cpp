// Tests of YOLO heads on tensors that are encoded from the published description of each network.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/families.hpp"

#include "core/heads/head_test_support.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::heads {
namespace yolo_heads_test {

constexpr size_t kClasses = 6;
// A picture of 64 x 64 pixels has 64 + 16 + 4 cells of 8, 16 and 32 pixels, row after row.
constexpr size_t kCells = 84;
constexpr Size kInput{64, 64};
const float kNan = NAN;

struct Cell {
  float column, row, stride;
};
Cell cell_of(size_t index) {
  size_t first = 0;
  for (const size_t stride : {8u, 16u, 32u}) {
    const size_t side = 64 / stride;
    if (index < first + side * side)
      return {static_cast<float>((index - first) % side),
              static_cast<float>((index - first) / side), static_cast<float>(stride)};
    first += side * side;
  }
  return {};
}

// Objects, and the cell (or row) that gives each.
struct Placed {
  TestObject object;
  size_t cell;
};
const std::vector<Placed> kObjects{
    {{4, 8, 20, 40, 0.9f, 2}, 3}, {{30, 30, 62, 50, 0.6f, 0}, 70}, {{1, 2, 63, 60, 0.75f, 5}, 83}};
std::vector<TestObject> objects() {
  std::vector<TestObject> out;
  for (const auto& placed : kObjects) out.push_back(placed.object);
  return out;
}

enum class Coding { Pixels, Picture, Cells };

// Rows of centre, size, [objectness], scores and `extra` numbers, with noise below the threshold.
Floats encode(const std::vector<Placed>& placed, Coding coding, bool has_objectness,
              size_t extra = 0, size_t rows = kCells) {
  const size_t fixed = has_objectness ? 5 : 4, length = fixed + kClasses + extra;
  std::mt19937 random(7);
  std::uniform_real_distribution<float> noise(0, 0.1f);
  Floats out(rows * length);
  const auto put = [&](size_t index, const TestObject& object, float score) {
    const Cell cell = cell_of(index % kCells);
    const float x = (object.x1 + object.x2) / 2, y = (object.y1 + object.y2) / 2;
    const float width = object.x2 - object.x1, height = object.y2 - object.y1;
    float* row = &out[index * length];
    if (coding == Coding::Pixels)
      row[0] = x, row[1] = y, row[2] = width, row[3] = height;
    else if (coding == Coding::Picture)
      row[0] = x / 64, row[1] = y / 64, row[2] = width / 64, row[3] = height / 64;
    else
      row[0] = x / cell.stride - cell.column, row[1] = y / cell.stride - cell.row,
      row[2] = std::log(width / cell.stride), row[3] = std::log(height / cell.stride);
    for (size_t c = 0; c < kClasses; ++c) row[fixed + c] = noise(random);
    if (has_objectness) {
      row[4] = score > 0 ? 0.95f : 0.05f;
      if (score > 0) row[fixed + static_cast<size_t>(object.class_index)] = score / 0.95f;
    } else if (score > 0) {
      row[fixed + static_cast<size_t>(object.class_index)] = score;
    }
  };
  for (size_t i = 0; i < rows; ++i) {  // background: boxes of the size of their cell
    const Cell cell = cell_of(i % kCells);
    const float x = cell.column * cell.stride, y = cell.row * cell.stride;
    put(i, {x, y, x + cell.stride, y + cell.stride, 0, 0}, 0);
  }
  for (const auto& each : placed) put(each.cell, each.object, each.object.score);
  return out;
}

HeadSetup setup_of(const char* head, Size input = kInput) {
  return {.head = head, .input = input};
}

TEST(YoloHeads, Version8GivesBoxesInBothOrdersOfDimensions) {
  for (const Coding coding : {Coding::Pixels, Coding::Picture})
    for (const auto& output : both_orders(encode(kObjects, coding, false), 4 + kClasses)) {
      const auto result = run_head({output}, {.labels = kClasses});
      EXPECT_EQ(result.family, "yolov8") << result.error;
      expect_found(result.found, objects());
    }
}

TEST(YoloHeads, Version5HasThreeRowsACell) {
  for (const Coding coding : {Coding::Pixels, Coding::Picture})
    for (const auto& output :
         both_orders(encode(kObjects, coding, true, 0, 3 * kCells), 5 + kClasses)) {
      const auto result = run_head({output});
      EXPECT_EQ(result.family, "yolov5") << result.error;
      expect_found(result.found, objects());
    }
}

TEST(YoloHeads, YoloxGivesCellsOrDecodedBoxes) {
  for (const Coding coding : {Coding::Cells, Coding::Pixels, Coding::Picture})
    for (const auto& output : both_orders(encode(kObjects, coding, true), 5 + kClasses)) {
      const auto result = run_head({output}, setup_of("yolox"));
      EXPECT_EQ(result.error, "");
      expect_found(result.found, objects());
    }
}

TEST(YoloHeads, YoloxDistinguishesCellsFromPixelsInTheFirstCell) {
  // The cell's offset of half a cell is 0.5, or 4 pixels.
  const std::vector<Placed> first{{{0, 0, 8, 8, 0.9f, 1}, 0}};
  for (const Coding coding : {Coding::Cells, Coding::Pixels, Coding::Picture}) {
    const auto result =
        run_head(both_orders(encode(first, coding, true), 5 + kClasses), setup_of("yolox"));
    EXPECT_SAYS(result.error, "yolox");  // two outputs
    const auto one =
        run_head({both_orders(encode(first, coding, true), 5 + kClasses)[0]}, setup_of("yolox"));
    expect_found(one.found, {first[0].object});
  }
}

TEST(YoloHeads, TheUnitCanBeNamed) {
  HeadSetup setup = setup_of("yolov8");
  setup.custom = {{"unit", "picture"}};
  const auto output = both_orders(encode(kObjects, Coding::Picture, false), 4 + kClasses)[1];
  expect_found(run_head({output}, setup).found, objects());
  setup.custom = {{"unit", "pixels"}};
  const auto found = run_head({output}, setup).found;
  ASSERT_EQ(found.size(), 3u);
  EXPECT_NEAR(found[0].x, 4.0f / 64, 1e-6f);
  setup.custom = {{"unit", "inches"}};
  EXPECT_SAYS(run_head({output}, setup).error, "custom=unit:inches");
  EXPECT_SAYS(run_head({output}, setup).error, "one of: pixels, picture");
}

TEST(YoloHeads, ThePictureOfTheFrameScalesPartsOfThePicture) {
  HeadSetup setup = setup_of("yolov8");
  setup.frame = {128, 64};
  const auto output = both_orders(encode(kObjects, Coding::Picture, false), 4 + kClasses)[0];
  const auto found = run_head({output}, setup).found;
  ASSERT_EQ(found.size(), 3u);
  EXPECT_NEAR(found[0].x, 8, 1e-4f);
  EXPECT_NEAR(found[0].y, 8, 1e-4f);
}

TEST(YoloHeads, TheInputSizeOfASquarePictureFollowsFromTheCells) {
  for (const Coding coding : {Coding::Pixels, Coding::Picture}) {
    const auto output = both_orders(encode(kObjects, coding, false), 4 + kClasses)[1];
    expect_found(run_head({output}, {.input = {}, .labels = kClasses}).found, objects());
  }
  const auto cells = both_orders(encode(kObjects, Coding::Cells, true), 5 + kClasses)[0];
  expect_found(run_head({cells}, setup_of("yolox", {})).found, objects());
}

TEST(YoloHeads, WithoutAnInputSizeOtherCellsNeedIt) {
  // 96 x 64 pixels have 96 + 24 + 6 cells.
  const size_t cells = 126, length = 4 + kClasses;
  Floats rows(cells * length, 0.0f);
  rows[0] = rows[1] = 0.5f, rows[2] = rows[3] = 0.1f, rows[4] = 0.9f;
  const auto output = both_orders(rows, length)[0];
  EXPECT_SAYS(recognised({output}, {.input = {}, .labels = kClasses}), "custom=input:");
  EXPECT_SAYS(run_head({output}, setup_of("yolov8", {})).error, "custom=input:640:640");
  const auto known = run_head({output}, {.input = {96, 64}, .labels = kClasses});
  expect_found(known.found, {{43.2f, 28.8f, 52.8f, 35.2f, 0.9f, 0}});
}

TEST(YoloHeads, QuantisedAndHalfOutputsAreRead) {
  const auto output = both_orders(encode(kObjects, Coding::Picture, false), 4 + kClasses)[1];
  for (const auto& other : {output.quantised(1.0f / 250, 3), output.halved()}) {
    const auto found = run_head({other}, {.labels = kClasses}).found;
    expect_found(found, objects(), 0.5f);  // a step is 64 / 250 pixels
  }
}

TEST(YoloHeads, OrientedBoxesHaveTheirCentreAndAnAngle) {
  Floats rows = encode(kObjects, Coding::Pixels, false, 1);
  const size_t length = 4 + kClasses + 1;
  for (size_t i = 0; i < kCells; ++i) rows[i * length + length - 1] = 0.01f * static_cast<float>(i);
  for (const auto& output : both_orders(rows, length)) {
    const auto result = run_head({output}, setup_of("yolov8-obb"));
    ASSERT_EQ(result.found.size(), 3u) << result.error;
    for (size_t i = 0; i < 3; ++i) {
      const auto& object = kObjects[i].object;
      EXPECT_NEAR(result.found[i].x, (object.x1 + object.x2) / 2, 1e-4f);
      EXPECT_NEAR(result.found[i].y, (object.y1 + object.y2) / 2, 1e-4f);
      EXPECT_NEAR(result.found[i].width, object.x2 - object.x1, 1e-4f);
      EXPECT_EQ(result.found[i].angle, 0.01f * static_cast<float>(kObjects[i].cell));
    }
  }
}

TEST(YoloHeads, PosesHaveKeyPoints) {
  constexpr size_t kPoints = 5;
  for (const Coding coding : {Coding::Pixels, Coding::Picture}) {
    Floats rows = encode(kObjects, coding, false, 3 * kPoints);
    const size_t length = 4 + kClasses + 3 * kPoints;
    const float unit = coding == Coding::Pixels ? 1.0f : 1.0f / 64;
    for (size_t i = 0; i < kCells; ++i)
      for (size_t k = 0; k < kPoints; ++k) {
        float* point = &rows[i * length + 4 + kClasses + 3 * k];
        point[0] = static_cast<float>(k + i % 50) * unit,
        point[1] = static_cast<float>(2 * k) * unit;
        point[2] = 0.1f * static_cast<float>(k);
      }
    rows[70 * length + 4 + kClasses] = kNan;
    for (const auto& output : both_orders(rows, length)) {
      HeadSetup setup = setup_of("yolov8-pose");
      setup.custom = {{"keypoints", "5"}};
      setup.tasks = kPose;
      const auto result = run_head({output}, setup);
      EXPECT_EQ(result.features.points_per_object, kPoints) << result.error;
      expect_found(result.found, objects());
      ASSERT_EQ(result.details.points.size(), 3 * kPoints);
      for (size_t k = 0; k < kPoints; ++k) {
        EXPECT_NEAR(result.details.points[k].x, static_cast<float>(k + 3), 1e-4f);
        EXPECT_NEAR(result.details.points[k].y, static_cast<float>(2 * k), 1e-4f);
        EXPECT_EQ(result.details.points[k].score, 0.1f * static_cast<float>(k));
      }
      EXPECT_EQ(result.details.points[kPoints], results::KeyPoint{});  // not a number
    }
  }
}

TEST(YoloHeads, KeyPointsMustFitTheRow) {
  const auto output = both_orders(encode({}, Coding::Pixels, false, 3), 4 + kClasses + 3)[0];
  HeadSetup setup = setup_of("yolov8-pose");
  for (const char* points : {"6", "0", "x", "9999"}) {
    setup.custom = {{"keypoints", points}};
    EXPECT_SAYS(run_head({output}, setup).error, std::string("custom=keypoints:") + points);
  }
}

// Prototype k is 10 right of column k and -10 elsewhere, so a weight on it draws that edge.
TEST(YoloHeads, SegmentationDrawsMasksOverTheBoxes) {
  constexpr size_t kPrototypes = 4, kSide = 16;
  Floats planes;
  for (size_t k = 0; k < kPrototypes; ++k)
    for (size_t y = 0; y < kSide; ++y)
      for (size_t x = 0; x < kSide; ++x) planes.push_back(x >= 4 * k ? 10.0f : -10.0f);
  const std::vector<Placed> one{{{8, 16, 40, 48, 0.9f, 2}, 3}};
  for (const bool is_version_5 : {false, true}) {
    const size_t fixed = is_version_5 ? 5 : 4, length = fixed + kClasses + kPrototypes;
    Floats rows =
        encode(one, Coding::Pixels, is_version_5, kPrototypes, is_version_5 ? 3 * kCells : kCells);
    rows[3 * length + fixed + kClasses + 1] = 1;  // column 4 and right of it: 16 pixels
    const auto packed = transposed(planes, kSide * kSide);
    for (const auto& output : both_orders(rows, length))
      for (const auto& prototypes :
           {TestOutput("16:16:4:1", planes), TestOutput("4:16:16:1", packed)})
        for (const bool is_swapped : {false, true}) {
          const auto result = run_head(
              is_swapped ? std::vector{prototypes, output} : std::vector{output, prototypes},
              {.tasks = kSegmentation});
          EXPECT_EQ(result.family, is_version_5 ? "yolov5-seg" : "yolov8-seg") << result.error;
          EXPECT_TRUE(result.features.has_masks);
          ASSERT_EQ(result.found.size(), 1u);
          // The box is 8 cells wide and high.
          ASSERT_EQ(result.details.mask_width, 8u);
          ASSERT_EQ(result.details.mask_height, 8u);
          ASSERT_EQ(result.details.masks.size(), 64u);
          for (size_t y = 0; y < 8; ++y)
            for (size_t x = 0; x < 8; ++x)
              EXPECT_EQ(result.details.masks[8 * y + x], x < 2 ? 0 : 255) << x << ", " << y;
        }
  }
}

TEST(YoloHeads, PrototypesMayHaveAnotherSizeButNotAnotherAspect) {
  constexpr size_t kPrototypes = 3, kLength = 4 + kClasses + kPrototypes;
  Floats rows = encode({{{8, 16, 40, 48, 0.9f, 2}, 3}}, Coding::Pixels, false, kPrototypes);
  rows[3 * kLength + 4 + kClasses] = 5;
  const auto output = both_orders(rows, kLength)[1];
  const auto result = run_head({output, TestOutput("8:8:3:1", Floats(8 * 8 * 3, 1))});
  EXPECT_EQ(result.family, "yolov8-seg") << result.error;
  EXPECT_EQ(result.details.mask_width, 4u);
  EXPECT_EQ(result.details.masks, std::vector<uint8_t>(16, 253));  // 255 / (1 + exp(-5))
  const TestOutput wide("16:8:3:1", Floats(16 * 8 * 3, 1));
  EXPECT_SAYS(recognised({output, wide}), "no head of this mode fits these outputs");
  EXPECT_SAYS(run_head({output, wide}, setup_of("yolov8-seg")).error,
              "the outputs are not those of the head yolov8-seg");
}

TEST(YoloHeads, CellsMayBeBeyondTheEdge) {
  // 60 x 40 pixels: 8 * 5, 4 * 3 and 2 * 2 cells.
  const size_t cells = 56, length = 4 + kClasses;
  Floats rows(cells * length);
  rows[0] = 30, rows[1] = 20, rows[2] = rows[3] = 10, rows[4] = 0.9f;
  const auto result = run_head({both_orders(rows, length)[1]}, {.input = {60, 40}});
  EXPECT_EQ(result.family, "yolov8") << result.error;
  expect_found(result.found, {{25, 15, 35, 25, 0.9f, 0}});
}

TEST(YoloHeads, NumbersThatAreNotFiniteGiveNoObjects) {
  const size_t length = 4 + kClasses;
  for (const float number : {kNan, INFINITY, -INFINITY}) {
    for (const auto& output : both_orders(Floats(kCells * length, number), length))
      EXPECT_EQ(run_head({output}, setup_of("yolov8")).found.size(), 0u);
    // One number of one object.
    for (size_t value = 0; value < 4 + 1; ++value) {
      Floats rows = encode(kObjects, Coding::Pixels, false);
      const size_t bad = value == 4 ? 4 + 2 : value;  // the score of class 2, or the box
      rows[3 * length + bad] = number;
      for (const auto& output : both_orders(rows, length))
        EXPECT_EQ(run_head({output}, setup_of("yolov8")).found.size(), 2u) << value;
    }
  }
}

TEST(YoloHeads, TheThresholdIsTheLeastScoreAndZerosAreNoObjects) {
  const auto output = both_orders(encode(kObjects, Coding::Pixels, false), 4 + kClasses)[1];
  HeadSetup setup = setup_of("yolov8");
  setup.threshold = 0.75f;
  EXPECT_EQ(run_head({output}, setup).found.size(), 2u);
  setup.threshold = std::nextafter(0.75f, 1.0f);
  EXPECT_EQ(run_head({output}, setup).found.size(), 1u);
  setup.threshold = 0;
  EXPECT_EQ(run_head({output}, setup).found.size(), kCells);
  const auto zeros = both_orders(Floats(kCells * (4 + kClasses)), 4 + kClasses)[1];
  EXPECT_EQ(run_head({zeros}, setup).found.size(), 0u);
}

TEST(YoloHeads, ReadsAHundredThousandRows) {
  constexpr size_t kRows = 100000, kLength = 6;
  Floats rows(kRows * kLength);
  for (size_t i = 0; i < kRows; ++i) {
    float* row = &rows[i * kLength];
    row[0] = row[1] = static_cast<float>(i % 1000), row[2] = row[3] = 5, row[4 + i % 2] = 0.5f;
  }
  for (const auto& output : both_orders(rows, kLength))
    EXPECT_EQ(run_head({output}, setup_of("yolov8", {1024, 1024})).found.size(), kRows);
}

TEST(YoloHeads, RefusesOtherOutputs) {
  for (const char* head :
       {"yolov8", "yolov8-seg", "yolov8-pose", "yolov8-obb", "yolov5", "yolov5-seg", "yolox"}) {
    EXPECT_SAYS(run_head({TestOutput("3:1", Floats(3))}, setup_of(head)).error,
                std::string("the outputs are not those of the head ") + head);
    EXPECT_SAYS(run_head({}, setup_of(head)).error, "the outputs are not those of");
  }
}

}  // namespace yolo_heads_test
}  // namespace weir::heads
