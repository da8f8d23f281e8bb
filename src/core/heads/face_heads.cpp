// Reads boxes and key points of YuNet and UltraFace.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/families.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/heads/coordinates.hpp"
#include "core/heads/head_options.hpp"
#include "core/heads/output_shapes.hpp"
#include "core/heads/points_head.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::heads {
namespace {

using detection::Candidate;
using detection::Candidates;

// YuNet: Wu, Peng, Yu, "YuNet: A Tiny Millisecond-level Face Detector", 2023.

constexpr std::array<uint32_t, 3> kYunetStrides{8, 16, 32};
constexpr size_t kYunetPoints = 5, kYunetOutputs = 12;

// The outputs of one grid. The two scores are multiplied, so their order does not matter.
struct YunetGrid {
  uint32_t stride = 0;
  size_t cells = 0;
  std::vector<size_t> scores;
  size_t box = 0, points = 0;
};

// The outputs by grid; empty if they are not those of YuNet.
std::vector<YunetGrid> yunet_grids(const ModelSignature& model) {
  if (model.outputs.size() != kYunetOutputs) return {};
  std::map<size_t, YunetGrid, std::greater<>> by_cells;
  size_t boxes = 0, points = 0;
  for (size_t i = 0; i < model.outputs.size(); ++i) {
    const OutputSignature& output = model.outputs[i];
    if (const size_t rows = matrix_rows(output, 4); rows > 0)
      by_cells[rows].box = i, ++boxes;
    else if (const size_t with_points = matrix_rows(output, 2 * kYunetPoints); with_points > 0)
      by_cells[with_points].points = i, ++points;
    else
      by_cells[matrix_rows(output, 1)].scores.push_back(i);
  }
  std::vector<YunetGrid> grids;
  for (auto& [cells, grid] : by_cells) {
    if (grids.size() == kYunetStrides.size() || cells == 0 || grid.scores.size() != 2) return {};
    grid.cells = cells;
    grid.stride = kYunetStrides[grids.size()];
    grids.push_back(grid);
  }
  const bool complete = grids.size() == 3 && boxes == 3 && points == 3;
  return complete ? grids : std::vector<YunetGrid>{};
}

class Yunet final : public Head {
 public:
  Yunet(std::vector<YunetGrid> grids, float threshold)
      : grids_(std::move(grids)), threshold_(threshold) {}

  results::Features features() const override { return {.points_per_object = kYunetPoints}; }
  Suppression suppression() const noexcept override { return Suppression::AnyClass; }

  Candidates find(OutputValues& outputs, Size input) override {
    need_input_size(input);
    Candidates found;
    uint32_t row = 0;
    for (const YunetGrid& grid : grids_) {
      const size_t columns = count_columns(grid, input);
      const auto first = outputs.read(grid.scores[0]), second = outputs.read(grid.scores[1]);
      for (size_t cell = 0; cell < grid.cells; ++cell, ++row) {
        const float score = std::sqrt(to_probability(first[cell]) * to_probability(second[cell]));
        if (!(score >= threshold_) || score == 0) continue;
        const float* box = outputs.read(grid.box).data() + 4 * cell;
        const size_t cell_x = cell % columns, cell_y = cell / columns;
        const auto stride = static_cast<float>(grid.stride);
        const float width = std::exp(box[2]) * stride, height = std::exp(box[3]) * stride;
        const Candidate candidate{.x = (static_cast<float>(cell_x) + box[0]) * stride - width / 2,
                                  .y = (static_cast<float>(cell_y) + box[1]) * stride - height / 2,
                                  .width = width,
                                  .height = height,
                                  .score = score,
                                  .class_index = 0,
                                  .row = row};
        if (candidate.is_finite()) found.push_back(candidate);
      }
    }
    return found;
  }

  void complete(OutputValues& outputs, std::span<const Candidate> kept, Size input,
                results::FrameResults* results) override {
    for (const Candidate& candidate : kept) {
      size_t cell = candidate.row;
      auto grid = grids_.begin();
      for (; cell >= grid->cells; ++grid) cell -= grid->cells;
      const size_t columns = count_columns(*grid, input);
      const size_t cell_x = cell % columns, cell_y = cell / columns;
      const float* points = outputs.read(grid->points).data() + 2 * kYunetPoints * cell;
      const auto stride = static_cast<float>(grid->stride);
      for (size_t i = 0; i < kYunetPoints; ++i)
        results->points.push_back(
            key_point((static_cast<float>(cell_x) + points[2 * i]) * stride,
                      (static_cast<float>(cell_y) + points[2 * i + 1]) * stride, candidate.score));
    }
  }

 private:
  static size_t count_columns(const YunetGrid& grid, Size input) {
    const size_t columns = input.width / grid.stride, rows = input.height / grid.stride;
    if (columns * rows == grid.cells) return columns;
    throw Failure({.code = Code::SPEC_MISMATCH,
                   .what = "the YuNet outputs belong to a different picture size",
                   .offered = std::to_string(grid.cells) + " cells of " +
                              std::to_string(grid.stride) + " pixels for an input of " +
                              std::to_string(input.width) + " x " + std::to_string(input.height),
                   .needed = std::to_string(columns * rows) + " cells",
                   .fix = "tensor_decoder custom=input:640:480"});
  }

  std::vector<YunetGrid> grids_;
  float threshold_;
};

Match fit_yunet(const ModelSignature& model) {
  if (yunet_grids(model).empty()) return Match::No;
  return any_name_has(model, "cls_8") && any_name_has(model, "kps_8") ? Match::Certain
                                                                      : Match::Possible;
}

std::unique_ptr<Head> open_yunet(const ModelSignature& model, const HeadOptions& options) {
  auto grids = yunet_grids(model);
  if (grids.empty()) throw wrong_outputs(model, kYunet);
  return std::make_unique<Yunet>(std::move(grids), options.threshold);
}

// UltraFace: the prior boxes and variances that its authors publish
// (Ultra-Light-Fast-Generic-Face-Detector-1MB).

struct PriorLayer {
  uint32_t stride;
  std::vector<float> sides;  // pixels
};
const std::array<PriorLayer, 4>& prior_layers() {
  static const std::array<PriorLayer, 4> layers{
      {{8, {10, 16, 24}}, {16, {32, 48}}, {32, {64, 96}}, {64, {128, 192, 256}}}};
  return layers;
}

uint32_t face_cells_along(uint32_t pixels, uint32_t stride) {
  return pixels / stride + (pixels % stride != 0 ? 1 : 0);
}

size_t prior_count(Size input) {
  size_t count = 0;
  for (const auto& [stride, sides] : prior_layers())
    count += size_t{face_cells_along(input.width, stride)} *
             face_cells_along(input.height, stride) * sides.size();
  return count;
}

struct Prior {
  float x, y, width, height;  // centre and size, as parts of the picture
};

std::vector<Prior> make_priors(Size input) {
  const auto part = [](float value) { return std::clamp(value, 0.0f, 1.0f); };
  const auto picture_width = static_cast<float>(input.width);
  const auto picture_height = static_cast<float>(input.height);
  std::vector<Prior> priors;
  for (const auto& [stride, sides] : prior_layers())
    for (uint32_t y = 0; y < face_cells_along(input.height, stride); ++y)
      for (uint32_t x = 0; x < face_cells_along(input.width, stride); ++x)
        for (const float side : sides)
          priors.push_back(
              {part((static_cast<float>(x) + 0.5f) * static_cast<float>(stride) / picture_width),
               part((static_cast<float>(y) + 0.5f) * static_cast<float>(stride) / picture_height),
               part(side / picture_width), part(side / picture_height)});
  return priors;
}

struct UltrafaceOutputs {
  size_t scores, boxes, count;
  Size input;
};

// The published sizes of the input count where it is not known.
std::optional<UltrafaceOutputs> ultraface_outputs(const ModelSignature& model) {
  if (model.outputs.size() != 2) return std::nullopt;
  for (const size_t boxes : {0u, 1u}) {
    const size_t count = matrix_rows(model.outputs[boxes], 4);
    if (count == 0 || matrix_rows(model.outputs[1 - boxes], 2) != count) continue;
    for (const Size input : {model.input, Size{320, 240}, Size{640, 480}}) {
      if (prior_count(input) == count) return UltrafaceOutputs{1 - boxes, boxes, count, input};
      if (model.input.width > 0) break;
    }
  }
  return std::nullopt;
}

class Ultraface final : public Head {
 public:
  Ultraface(const UltrafaceOutputs& outputs, Unit unit, float threshold, bool is_raw)
      : outputs_(outputs),
        threshold_(threshold),
        boxes_(unit, threshold),
        priors_(is_raw ? make_priors(outputs.input) : std::vector<Prior>{}) {}

  results::Features features() const override { return {}; }
  Suppression suppression() const noexcept override { return Suppression::AnyClass; }

  Candidates find(OutputValues& outputs, Size input) override {
    if (input.width == 0) input = outputs_.input;
    const auto scores = outputs.read(outputs_.scores);
    boxes_.begin();
    for (size_t i = 0; i < outputs_.count; ++i) {
      const float score = scores[2 * i + 1];  // after the background's
      if (!(score >= threshold_ && score > 0)) continue;
      const Box box = box_at(i, outputs.read(outputs_.boxes).data() + 4 * i);
      boxes_.add(std::array{box.x1, box.y1, box.x2, box.y2}, to_probability(score), 0, i);
    }
    auto found = boxes_.take(input);
    if (!priors_.empty()) return found;
    if (are_offsets(outputs.read(outputs_.boxes))) warn_once(offsets_as_boxes());
    warn_once(boxes_.contradiction());
    return found;
  }

 private:
  // Whether many boxes have their corners exchanged, as if their numbers were relative to priors.
  bool are_offsets(std::span<const float> values) const {
    constexpr size_t kSamples = 64;
    size_t exchanged = 0;
    for (size_t i = 0; i < kSamples; ++i) {
      const float* const box = values.data() + 4 * (i * outputs_.count / kSamples);
      exchanged += box[2] < box[0] || box[3] < box[1];
    }
    return exchanged > kSamples / 4;
  }
  static Error offsets_as_boxes() {
    return {.code = Code::SPEC_MISMATCH,
            .what = "the boxes of faces look like offsets from prior boxes",
            .offered =
                "many boxes whose right edge is left of the left one, or whose lower edge is "
                "above the upper one",
            .needed = "decoded boxes: x1, y1, x2, y2",
            .fix = "custom=head:ultraface-raw"};
  }
  Box box_at(size_t index, const float* values) const {
    if (priors_.empty()) return {values[0], values[1], values[2], values[3]};
    constexpr float kCentreVariance = 0.1f, kSizeVariance = 0.2f;
    const Prior& prior = priors_[index];
    const float x = prior.x + values[0] * kCentreVariance * prior.width;
    const float y = prior.y + values[1] * kCentreVariance * prior.height;
    const float width = prior.width * std::exp(values[2] * kSizeVariance);
    const float height = prior.height * std::exp(values[3] * kSizeVariance);
    return {x - width / 2, y - height / 2, x + width / 2, y + height / 2};
  }

  UltrafaceOutputs outputs_;
  float threshold_;
  CornerBoxes boxes_;
  std::vector<Prior> priors_;  // empty: the boxes are decoded
};

// Only the model with decoded boxes names its outputs. The number of priors of a known input is as
// good a sign as a name, for both kinds of boxes.
bool is_named(const ModelSignature& model) {
  return any_name_has(model, "scores") && any_name_has(model, "boxes");
}

Match fit_ultraface(const ModelSignature& model) {
  if (!ultraface_outputs(model)) return Match::No;
  return is_named(model) || model.input.width > 0 ? Match::Certain : Match::Possible;
}

Match fit_ultraface_raw(const ModelSignature& model) {
  if (!ultraface_outputs(model)) return Match::No;
  return !is_named(model) && model.input.width > 0 ? Match::Certain : Match::Possible;
}

template <bool kIsRaw>
std::unique_ptr<Head> open_ultraface(const ModelSignature& model, const HeadOptions& options) {
  const auto outputs = ultraface_outputs(model);
  if (!outputs) throw wrong_outputs(model, kIsRaw ? kUltrafaceRaw : kUltraface);
  const Unit unit = kIsRaw ? Unit::Picture : unit_setting(options);
  return std::make_unique<Ultraface>(*outputs, unit, options.threshold, kIsRaw);
}

}  // namespace

const Family kYunet{.name = "yunet",
                    .aliases = "",
                    .tasks = kDetection | kPose,
                    .outputs = "12 tensors: for strides 8, 16 and 32 two 1:N, one 4:N, one 10:N",
                    .custom = "",
                    .threshold = 0.6f,
                    .fit = fit_yunet,
                    .open = open_yunet};

const Family kUltraface{.name = "ultraface",
                        .aliases = "",
                        .tasks = kDetection,
                        .outputs = "2 tensors 2:N and 4:N (corners) for the N priors of the input",
                        .custom = "unit",
                        .threshold = 0.7f,
                        .fit = fit_ultraface,
                        .open = open_ultraface<false>};

const Family kUltrafaceRaw{.name = "ultraface-raw",
                           .aliases = "",
                           .tasks = kDetection,
                           .outputs = "2 tensors 2:N and 4:N (relative to N priors of the input)",
                           .custom = "",
                           .threshold = 0.7f,
                           .fit = fit_ultraface_raw,
                           .open = open_ultraface<true>};

}  // namespace weir::heads
