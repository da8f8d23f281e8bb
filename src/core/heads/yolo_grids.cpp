// Decodes grids of cells with anchors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/families.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/detection/sigmoid.hpp"
#include "core/heads/coordinates.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::heads {
namespace {

using detection::Candidate;
using detection::Candidates;

constexpr size_t kFixed = 5, kAnchors = 3;  // numbers before the classes; anchors of a cell
constexpr uint32_t kMaxStride = 32;         // pixels of a cell of the smallest grid
constexpr char kExample[] = "10/13/16/30/33/23/30/61/62/45/59/119/116/90/156/198/373/326";

// Width and height of the anchors in pixels, of the grid of the smallest cells first.
using Anchors = std::span<const float>;
constexpr std::array kOfVersion3And5{10.f, 13.f, 16.f,  30.f,  33.f, 23.f,  30.f,  61.f,  62.f,
                                     45.f, 59.f, 119.f, 116.f, 90.f, 156.f, 198.f, 373.f, 326.f};
constexpr std::array kOfVersion7{12.f, 16.f, 19.f,  36.f,  40.f,  28.f,  36.f,  75.f,  76.f,
                                 55.f, 72.f, 146.f, 142.f, 110.f, 192.f, 243.f, 459.f, 401.f};

// One grid, and the steps from one number to the next along each dimension.
struct YoloGrid {
  size_t output = 0, columns = 0, rows = 0, values = 0;
  size_t anchor_step = 0, value_step = 0, row_step = 0, column_step = 0;

  size_t count() const noexcept { return columns * rows * values * kAnchors; }
  size_t at(size_t anchor, size_t row, size_t column, size_t value) const noexcept {
    return anchor * anchor_step + row * row_step + column * column_step + value * value_step;
  }
};

// 3*V:W:H, W:H:3*V or V:W:H:3 with V = 5 + classes.
std::optional<YoloGrid> find_grid(const Shape& shape, size_t output) {
  const size_t a = shape[0], b = shape[1], c = shape[2], d = shape[3];
  if (shape.min_rank() == 4 && d == kAnchors && a > kFixed)
    return YoloGrid{output, b, c, a, a * b * c, 1, a * b, a};
  if (shape.min_rank() != 3) return std::nullopt;
  const auto has_values = [](size_t extent) {
    return extent % kAnchors == 0 && extent / kAnchors > kFixed;
  };
  // The numbers of a cell are the dimension that leaves a grid of the same aspect.
  const bool is_planar = has_values(c) && (a == b || !has_values(a));
  if (is_planar) return YoloGrid{output, a, b, c / kAnchors, a * b * c / kAnchors, a * b, a, 1};
  if (has_values(a)) return YoloGrid{output, b, c, a / kAnchors, a / kAnchors, 1, a * b, a};
  return std::nullopt;
}

// Two or three grids, each of half the size of the one before; empty if they are not.
std::vector<YoloGrid> find_grids(const ModelSignature& model) {
  std::vector<YoloGrid> grids;
  if (model.outputs.size() < 2 || model.outputs.size() > 3) return {};
  for (size_t i = 0; i < model.outputs.size(); ++i) {
    const auto grid = find_grid(model.outputs[i].shape, i);
    if (!grid) return {};
    grids.push_back(*grid);
  }
  std::sort(grids.begin(), grids.end(),
            [](const YoloGrid& a, const YoloGrid& b) { return a.columns > b.columns; });
  for (size_t i = 1; i < grids.size(); ++i) {
    const YoloGrid &large = grids[i - 1], &small = grids[i];
    if (large.columns != 2 * small.columns || large.rows != 2 * small.rows ||
        large.values != small.values)
      return {};
  }
  return grids;
}

enum class Version { Three, FiveOrSeven };

class YoloGrids final : public Head {
 public:
  YoloGrids(std::vector<YoloGrid> grids, std::vector<float> anchors, Size input, Version version,
            ScoreKind kind, float threshold)
      : grids_(std::move(grids)),
        anchors_(std::move(anchors)),
        input_(input),
        version_(version),
        kind_(kind),
        threshold_(threshold) {}

  results::Features features() const override { return {}; }
  Suppression suppression() const noexcept override { return Suppression::ByClass; }
  size_t classes() const noexcept override { return grids_.front().values - kFixed; }

  Candidates find(OutputValues& outputs, Size frame_input) override {
    const Size input = frame_input.width > 0 ? frame_input : input_;
    for (const YoloGrid& grid : grids_) {
      const auto numbers = outputs.read(grid.output);
      if (numbers.size() != grid.count())
        throw Failure({.code = Code::SPEC_MISMATCH,
                       .what = "a grid has a different size than the head was opened for",
                       .offered = std::to_string(numbers.size()) + " numbers",
                       .needed = std::to_string(grid.count())});
      if (kind_ == ScoreKind::Automatic && are_logits(numbers)) kind_ = ScoreKind::Logits;
    }
    Candidates found;
    uint32_t row = 0;
    for (size_t i = 0; i < grids_.size(); ++i) {
      const auto numbers = outputs.read(grids_[i].output);
      for (size_t anchor = 0; anchor < kAnchors; ++anchor)
        add(grids_[i], numbers, anchor, std::span(anchors_).subspan((i * kAnchors + anchor) * 2, 2),
            input, &row, &found);
    }
    return found;
  }

 private:
  float activated(float number) const noexcept {
    return kind_ == ScoreKind::Logits ? detection::sigmoid(number) : number;
  }

  void add(const YoloGrid& grid, std::span<const float> numbers, size_t anchor,
           std::span<const float> size, Size input, uint32_t* row, Candidates* found) const {
    for (size_t y = 0; y < grid.rows; ++y)
      for (size_t x = 0; x < grid.columns; ++x, ++*row) {
        const auto number = [&](size_t value) { return numbers[grid.at(anchor, y, x, value)]; };
        const float objectness = activated(number(4));
        if (!(objectness >= threshold_)) continue;
        const size_t best = best_class(number, grid.values);
        const float score = objectness * activated(number(best));
        if (!reaches(score, threshold_)) continue;
        Candidate candidate = make_box(number, x, y, size);
        const float step_x = static_cast<float>(input.width) / static_cast<float>(grid.columns);
        const float step_y = static_cast<float>(input.height) / static_cast<float>(grid.rows);
        candidate.x = candidate.x * step_x - candidate.width / 2;
        candidate.y = candidate.y * step_y - candidate.height / 2;
        candidate.score = score;
        candidate.class_index = static_cast<int32_t>(best - kFixed);
        candidate.row = *row;
        if (candidate.is_finite()) found->push_back(candidate);
      }
  }

  // Which of a cell's numbers is the largest score of a class.
  template <class Number>
  static size_t best_class(const Number& number, size_t values) {
    size_t best = kFixed;
    for (size_t value = kFixed + 1; value < values; ++value)
      if (number(value) > number(best) || std::isnan(number(best))) best = value;
    return best;
  }

  // The centre, in cells, and the size, in pixels, of a cell's box.
  template <class Number>
  Candidate make_box(const Number& number, size_t x, size_t y, std::span<const float> size) const {
    const float right = activated(number(0)), down = activated(number(1));
    const auto left = static_cast<float>(x), top = static_cast<float>(y);
    if (version_ == Version::Three)
      return {.x = left + right,
              .y = top + down,
              .width = std::exp(number(2)) * size[0],
              .height = std::exp(number(3)) * size[1]};
    return {.x = left + (2 * right - 0.5f),
            .y = top + (2 * down - 0.5f),
            .width = 4 * activated(number(2)) * activated(number(2)) * size[0],
            .height = 4 * activated(number(3)) * activated(number(3)) * size[1]};
  }

  std::vector<YoloGrid> grids_;
  std::vector<float> anchors_;
  Size input_;
  Version version_;
  ScoreKind kind_;  // logits, once one was seen
  float threshold_;
};

Match fit_grids(const ModelSignature& model) {
  const auto grids = find_grids(model);
  if (grids.empty()) return Match::No;
  const YoloGrid& smallest = grids.back();
  const bool has_size = model.input.width > 0;
  return !has_size || (smallest.columns * kMaxStride == model.input.width &&
                       smallest.rows * kMaxStride == model.input.height)
             ? Match::Possible
             : Match::No;
}

std::unique_ptr<Head> open_grids(const ModelSignature& model, const HeadOptions& options,
                                 const Family& family, Version version, Anchors usual) {
  auto grids = find_grids(model);
  if (grids.empty()) throw wrong_outputs(model, family);
  const size_t needed = grids.size() * kAnchors * 2;
  std::vector<float> anchors = numbers_setting(options, "anchors", kExample);
  if (anchors.empty() && usual.size() == needed) anchors.assign(usual.begin(), usual.end());
  if (anchors.size() != needed)
    throw wrong_setting(options, "anchors",
                        std::to_string(needed) +
                            " numbers: width/height of 3 anchors of each grid in pixels, the grid "
                            "of the smallest cells first",
                        kExample);
  const Size input = model.input.width > 0
                         ? model.input
                         : Size{static_cast<uint32_t>(grids.back().columns) * kMaxStride,
                                static_cast<uint32_t>(grids.back().rows) * kMaxStride};
  return std::make_unique<YoloGrids>(std::move(grids), std::move(anchors), input, version,
                                     score_kind(options), options.threshold);
}

constexpr Family make_family(std::string_view name, std::string_view aliases,
                             std::unique_ptr<Head> (*open)(const ModelSignature&,
                                                           const HeadOptions&)) {
  return {.name = name,
          .aliases = aliases,
          .tasks = kDetection,
          .outputs = "2 or 3 tensors 3*V:W:H, W:H:3*V or V:W:H:3 with V = 5+CLASSES",
          .custom = "anchors,scores",
          .threshold = 0.25f,
          .fit = fit_grids,
          .open = open};
}

}  // namespace

const Family kYolov3Grids =
    make_family("yolov3-grids", "yolov4-grids", [](const ModelSignature& m, const HeadOptions& o) {
      return open_grids(m, o, kYolov3Grids, Version::Three, kOfVersion3And5);
    });

const Family kYolov5Grids =
    make_family("yolov5-grids", "", [](const ModelSignature& m, const HeadOptions& o) {
      return open_grids(m, o, kYolov5Grids, Version::FiveOrSeven, kOfVersion3And5);
    });

const Family kYolov7Grids =
    make_family("yolov7-grids", "", [](const ModelSignature& m, const HeadOptions& o) {
      return open_grids(m, o, kYolov7Grids, Version::FiveOrSeven, kOfVersion7);
    });

}  // namespace weir::heads
