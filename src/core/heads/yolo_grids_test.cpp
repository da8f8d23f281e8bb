// Tests of YOLO heads that give one grid for each size of cells.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/families.hpp"

#include <numeric>

#include "core/heads/head_test_support.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::heads {
namespace yolo_grids_test {

constexpr size_t kClasses = 4, kValues = 5 + kClasses, kAnchors = 3;
// Of the papers, in pixels: 8, 16 and 32 pixels a cell.
const float kVersion5[9][2] = {{10, 13},  {16, 30},  {33, 23},   {30, 61},  {62, 45},
                               {59, 119}, {116, 90}, {156, 198}, {373, 326}};
const float kVersion7[9][2] = {{12, 16},  {19, 36},   {40, 28},   {36, 75},  {76, 55},
                               {72, 146}, {142, 110}, {192, 243}, {459, 401}};

// An object of a cell and an anchor, on a picture of 128 x 64 pixels.
struct Placed {
  size_t grid, anchor, column, row;
  TestObject object;
};
const std::vector<Placed> kPlaced{{0, 1, 2, 3, {14, 12, 30, 44, 0.81f, 2}},
                                  {2, 0, 3, 1, {68, 10, 128, 64, 0.49f, 0}}};

float inverse(float p) {
  return std::log(p / (1 - p));
}

enum class Order { Planar, Packed, Rows };

std::vector<TestOutput> encode(const std::string& head, Order order, bool as_probabilities) {
  const auto& anchors = head == "yolov7-grids" ? kVersion7 : kVersion5;
  std::vector<TestOutput> out;
  for (size_t grid = 0; grid < 3; ++grid) {
    const size_t stride = size_t{8} << grid, columns = 128 / stride, rows = 64 / stride;
    Floats numbers(kAnchors * kValues * columns * rows, as_probabilities ? 0.01f : inverse(0.01f));
    for (const auto& placed : kPlaced) {
      if (placed.grid != grid) continue;
      const auto& object = placed.object;
      const float* anchor = anchors[3 * grid + placed.anchor];
      const auto s = static_cast<float>(stride);
      const float x = (object.x1 + object.x2) / 2 / s - static_cast<float>(placed.column);
      const float y = (object.y1 + object.y2) / 2 / s - static_cast<float>(placed.row);
      const float w = (object.x2 - object.x1) / anchor[0], h = (object.y2 - object.y1) / anchor[1];
      const auto code = [&](float p) { return as_probabilities ? p : inverse(p); };
      Floats values(kValues, code(0.01f));
      if (head == "yolov3-grids") {
        values[0] = code(x), values[1] = code(y), values[2] = std::log(w), values[3] = std::log(h);
      } else {
        values[0] = code((x + 0.5f) / 2), values[1] = code((y + 0.5f) / 2);
        values[2] = code(std::sqrt(w) / 2), values[3] = code(std::sqrt(h) / 2);
      }
      values[4] = code(std::sqrt(object.score));
      values[5 + static_cast<size_t>(object.class_index)] = code(std::sqrt(object.score));
      for (size_t v = 0; v < kValues; ++v) {
        const size_t a = placed.anchor, row = placed.row, column = placed.column;
        const size_t planar = ((a * kValues + v) * rows + row) * columns + column;
        const size_t packed = ((row * columns + column) * kAnchors + a) * kValues + v;
        const size_t in_rows = ((a * rows + row) * columns + column) * kValues + v;
        numbers[order == Order::Planar   ? planar
                : order == Order::Packed ? packed
                                         : in_rows] = values[v];
      }
    }
    const std::string size = std::to_string(columns) + ":" + std::to_string(rows);
    const std::string shape = order == Order::Planar   ? size + ":27:1"
                              : order == Order::Packed ? "27:" + size + ":1"
                                                       : "9:" + size + ":3:1";
    out.emplace_back(shape.c_str(), numbers);
  }
  return out;
}

const std::vector<TestObject> kObjects{kPlaced[0].object, kPlaced[1].object};

TEST(YoloGrids, BoxesAreRelativeToCellsAndAnchors) {
  for (const char* head : {"yolov3-grids", "yolov5-grids", "yolov7-grids"})
    for (const Order order : {Order::Planar, Order::Packed, Order::Rows}) {
      auto outputs = encode(head, order, false);
      for (const Size input : {Size{128, 64}, {}}) {
        const auto result = run_head(outputs, {.head = head, .input = input});
        EXPECT_EQ(result.error, "") << head;
        expect_found(result.found, kObjects, 2e-3f);
      }
      std::swap(outputs[0], outputs[2]);  // grids in another order
      expect_found(run_head(outputs, {.head = head, .input = {128, 64}}).found, kObjects, 2e-3f);
    }
}

TEST(YoloGrids, ProbabilitiesNeedNoSigmoid) {
  expect_found(run_head(encode("yolov5-grids", Order::Planar, true),
                        {.head = "yolov5-grids", .input = {128, 64}})
                   .found,
               kObjects, 2e-3f);
}

TEST(YoloGrids, AnchorsCanBeSet) {
  std::string anchors;
  for (const auto& [width, height] : kVersion7)
    anchors += std::to_string(width) + "/" + std::to_string(height) + "/";
  anchors.pop_back();
  const auto outputs = encode("yolov7-grids", Order::Planar, false);
  HeadSetup setup{.head = "yolov5-grids", .input = {128, 64}, .custom = {{"anchors", anchors}}};
  expect_found(run_head(outputs, setup).found, kObjects, 2e-3f);
  for (const char* bad : {"1/2/3", "1/x", ""}) {
    setup.custom["anchors"] = bad;
    EXPECT_SAYS(run_head(outputs, setup).error, std::string("custom=anchors:") + bad);
  }
  // Two grids have no usual anchors.
  setup.custom.clear();
  EXPECT_SAYS(run_head({outputs[0], outputs[1]}, setup).error, "12 numbers");
}

TEST(YoloGrids, TheVersionMustBeNamed) {
  EXPECT_SAYS(recognised(encode("yolov5-grids", Order::Planar, false), {.input = {128, 64}}),
              "yolov3-grids, yolov5-grids, yolov7-grids");
}

TEST(YoloGrids, NumbersThatAreNotFiniteGiveNoObjects) {
  for (const float number : {float(NAN), INFINITY, -INFINITY}) {
    auto outputs = encode("yolov3-grids", Order::Planar, false);
    for (auto& output : outputs) {
      Floats numbers = output.floats();
      std::fill(numbers.begin(), numbers.end(), number);
      output = TestOutput(output.facts.shape.to_string().c_str(), numbers);
    }
    EXPECT_EQ(run_head(outputs, {.head = "yolov3-grids", .input = {128, 64}}).found.size(), 0u);
  }
}

TEST(YoloGrids, RefuseOtherOutputs) {
  for (const char* head : {"yolov3-grids", "yolov5-grids", "yolov7-grids"}) {
    EXPECT_SAYS(
        run_head({TestOutput("27:8:8:1", Floats(27 * 64)), TestOutput("27:5:5:1", Floats(27 * 25))},
                 {.head = head})
            .error,
        std::string("the outputs are not those of the head ") + head);
  }
}

}  // namespace yolo_grids_test
}  // namespace weir::heads
