// Reads FastestDet (one grid), NanoDet (distributions of the distances to the edges), and YOLO-NAS
// and others whose scores and boxes are two outputs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/families.hpp"

#include <algorithm>
#include <cmath>

#include "core/detection/dense_scores.hpp"
#include "core/detection/sigmoid.hpp"
#include "core/heads/coordinates.hpp"
#include "core/heads/dense_layout.hpp"
#include "core/heads/output_shapes.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::heads {
namespace {

using detection::Candidate;
using detection::Candidates;
using detection::sigmoid;

constexpr size_t kCocoClasses = 80;

Failure other_size(size_t offered, size_t needed) {
  return Failure({.code = Code::SPEC_MISMATCH,
                  .what = "the frame has a different size than the head was opened for",
                  .offered = std::to_string(offered) + " numbers",
                  .needed = std::to_string(needed)});
}

// ---- FastestDet: planes of objectness, 4 values of the box, probabilities of classes ----

constexpr size_t kBeforeClasses = 5;
constexpr uint32_t kFastestDetStride = 16;  // pixels of a cell

struct Grid {
  size_t columns = 0, rows = 0, values = 0;
};

std::optional<Grid> find_grid(const ModelSignature& model) {
  if (model.outputs.size() != 1) return std::nullopt;
  const Shape& shape = model.outputs[0].shape;
  if (shape.min_rank() != 3 || shape[2] <= kBeforeClasses) return std::nullopt;
  return Grid{shape[0], shape[1], shape[2]};
}

class FastestDet final : public Head {
 public:
  FastestDet(const Grid& grid, Size input, float threshold)
      : grid_(grid), input_(input), threshold_(threshold) {}

  results::Features features() const override { return {}; }
  Suppression suppression() const noexcept override { return Suppression::ByClass; }
  size_t classes() const noexcept override { return grid_.values - kBeforeClasses; }

  Candidates find(OutputValues& outputs, Size frame_input) override {
    const Size input = frame_input.width > 0 ? frame_input : input_;
    const auto numbers = outputs.read(0);
    const size_t cells = grid_.columns * grid_.rows;
    if (numbers.size() != cells * grid_.values)
      throw other_size(numbers.size(), cells * grid_.values);
    best_.clear();
    const detection::DenseScores classes{.cells = cells,
                                         .values = grid_.values,
                                         .cells_are_inner = true,
                                         .first_class = kBeforeClasses,
                                         .classes = grid_.values - kBeforeClasses};
    detection::find_scored_cells(numbers, classes, 0, &best_);
    const auto width = static_cast<float>(input.width), height = static_cast<float>(input.height);
    const float step_x = width / static_cast<float>(grid_.columns);
    const float step_y = height / static_cast<float>(grid_.rows);
    Candidates found;
    for (const auto& best : best_) {
      const auto number = [&](size_t value) { return numbers[value * cells + best.cell]; };
      const float score = std::pow(number(0), 0.6f) * std::pow(best.score, 0.4f);
      if (!reaches(score, threshold_)) continue;
      const auto row_index = best.cell / grid_.columns;
      const auto column = static_cast<float>(best.cell % grid_.columns);
      const auto row = static_cast<float>(row_index);
      const float box_width = sigmoid(number(3)) * width, box_height = sigmoid(number(4)) * height;
      const Candidate candidate{.x = (column + std::tanh(number(1))) * step_x - box_width / 2,
                                .y = (row + std::tanh(number(2))) * step_y - box_height / 2,
                                .width = box_width,
                                .height = box_height,
                                .score = score,
                                .class_index = best.class_index,
                                .row = best.cell};
      if (candidate.is_finite()) found.push_back(candidate);
    }
    return found;
  }

 private:
  Grid grid_;
  Size input_;
  float threshold_;
  std::vector<detection::ScoredCell> best_;
};

Size fastest_det_input(const ModelSignature& model, const Grid& grid) {
  if (model.input.width > 0) return model.input;
  return {static_cast<uint32_t>(grid.columns) * kFastestDetStride,
          static_cast<uint32_t>(grid.rows) * kFastestDetStride};
}

Match fit_fastest_det(const ModelSignature& model) {
  const auto grid = find_grid(model);
  if (!grid) return Match::No;
  const Size input = fastest_det_input(model, *grid);
  return grid->columns * kFastestDetStride == input.width &&
                 grid->rows * kFastestDetStride == input.height
             ? Match::Possible
             : Match::No;
}

std::unique_ptr<Head> open_fastest_det(const ModelSignature& model, const HeadOptions& options) {
  const auto grid = find_grid(model);
  if (!grid) throw wrong_outputs(model, kFastestDet);
  return std::make_unique<FastestDet>(*grid, fastest_det_input(model, *grid), options.threshold);
}

// ---- NanoDet: rows of probabilities of classes, then 8 logits for each edge ----

constexpr size_t kBins = 8, kEdges = 4, kDistances = kBins * kEdges;

struct NanoDetOutput {
  DenseLayout layout;
  size_t classes = 0;
};

std::optional<NanoDetOutput> find_nano_det(const ModelSignature& model) {
  if (model.outputs.size() != 1) return std::nullopt;
  const auto layout = find_dense_layout(model.outputs[0].shape, model.input);
  if (!layout || layout->anchors != 1 || layout->values <= kDistances) return std::nullopt;
  return NanoDetOutput{*layout, layout->values - kDistances};
}

class NanoDet final : public Head {
 public:
  NanoDet(const NanoDetOutput& output, float threshold)
      : layout_(output.layout),
        scores_{.cells = output.layout.rows,
                .values = output.layout.values,
                .cells_are_inner = output.layout.rows_are_inner,
                .first_class = 0,
                .classes = output.classes},
        // The grids of the smaller model begin at the centres of cells.
        offset_(layout_.strides.size() == 3 ? 0.5f : 0.0f),
        places_(cell_places(layout_, layout_.input)),
        threshold_(threshold) {}

  results::Features features() const override { return {}; }
  Suppression suppression() const noexcept override { return Suppression::ByClass; }
  size_t classes() const noexcept override { return scores_.classes; }

  Candidates find(OutputValues& outputs, Size) override {
    const auto numbers = outputs.read(0);
    if (numbers.size() != scores_.cells * scores_.values)
      throw other_size(numbers.size(), scores_.cells * scores_.values);
    found_.clear();
    detection::find_scored_cells(numbers, scores_, threshold_, &found_);
    Candidates candidates;
    for (const auto& found : found_) {
      const CellPlace& place = places_[found.cell];
      const auto stride = static_cast<float>(place.stride);
      float edges[kEdges];
      for (size_t edge = 0; edge < kEdges; ++edge)
        edges[edge] = stride * distance(numbers, found.cell, scores_.classes + edge * kBins);
      const float x = (static_cast<float>(place.column) + offset_) * stride;
      const float y = (static_cast<float>(place.row) + offset_) * stride;
      const Candidate candidate{.x = x - edges[0],
                                .y = y - edges[1],
                                .width = edges[0] + edges[2],
                                .height = edges[1] + edges[3],
                                .score = found.score,
                                .class_index = found.class_index,
                                .row = found.cell};
      if (candidate.is_finite()) candidates.push_back(candidate);
    }
    return candidates;
  }

 private:
  // The mean of the bins, weighted by the softmax of their logits.
  float distance(std::span<const float> numbers, size_t cell, size_t first) const {
    float max = -INFINITY, sum = 0, weighted = 0;
    for (size_t i = 0; i < kBins; ++i) max = std::max(max, numbers[scores_.at(cell, first + i)]);
    for (size_t i = 0; i < kBins; ++i) {
      const float weight = std::exp(numbers[scores_.at(cell, first + i)] - max);
      sum += weight;
      weighted += weight * static_cast<float>(i);
    }
    return weighted / sum;
  }

  DenseLayout layout_;
  detection::DenseScores scores_;
  float offset_;
  std::vector<CellPlace> places_;
  float threshold_;
  std::vector<detection::ScoredCell> found_;
};

Match fit_nano_det(const ModelSignature& model) {
  const auto output = find_nano_det(model);
  if (!output || !metadata(model, "task").empty()) return Match::No;
  const bool is_usual = !output->layout.rows_are_inner && output->classes == kCocoClasses;
  if (model.labels > 0 ? model.labels == output->classes : is_usual) return Match::Certain;
  // Four or more classes beside 32 numbers for the edges also fit other families; without a sign
  // of NanoDet they are more likely.
  return Match::No;
}

std::unique_ptr<Head> open_nano_det(const ModelSignature& model, const HeadOptions& options) {
  const auto output = find_nano_det(model);
  if (!output) throw wrong_outputs(model, kNanoDet);
  return std::make_unique<NanoDet>(*output, options.threshold);
}

// ---- YOLO-NAS, PP-YOLOE, DAMO-YOLO: scores of classes and edges of boxes for each cell ----

struct ScoresAndBoxes {
  size_t scores = 0, boxes = 0;  // outputs
  DenseLayout layout;            // of the scores
};

std::optional<ScoresAndBoxes> find_scores_and_boxes(const ModelSignature& model) {
  if (model.outputs.size() != 2) return std::nullopt;
  // Four classes and boxes have the same shape: names decide, then the order of YOLO-NAS.
  const size_t likely = has_name_with(model.outputs[1], "box") ? 1 : 0;
  for (const size_t boxes : {likely, 1 - likely}) {
    const Shape& box = model.outputs[boxes].shape;
    const auto layout = find_dense_layout(model.outputs[1 - boxes].shape, model.input);
    if (layout && layout->anchors == 1 && box.min_rank() <= 2 && box[0] == 4 &&
        box[1] == layout->rows)
      return ScoresAndBoxes{1 - boxes, boxes, *layout};
  }
  return std::nullopt;
}

class YoloNas final : public Head {
 public:
  YoloNas(const ScoresAndBoxes& outputs, Unit unit, float threshold)
      : outputs_(outputs),
        scores_{.cells = outputs.layout.rows,
                .values = outputs.layout.values,
                .cells_are_inner = outputs.layout.rows_are_inner,
                .first_class = 0,
                .classes = outputs.layout.values},
        threshold_(threshold),
        boxes_(unit, threshold) {}

  results::Features features() const override { return {}; }
  Suppression suppression() const noexcept override { return Suppression::ByClass; }
  size_t classes() const noexcept override { return scores_.classes; }

  Candidates find(OutputValues& outputs, Size input) override {
    const auto scores = outputs.read(outputs_.scores), boxes = outputs.read(outputs_.boxes);
    if (scores.size() != scores_.cells * scores_.values)
      throw other_size(scores.size(), scores_.cells * scores_.values);
    if (boxes.size() != scores_.cells * 4) throw other_size(boxes.size(), scores_.cells * 4);
    found_.clear();
    detection::find_scored_cells(scores, scores_, threshold_, &found_);
    boxes_.begin();
    for (const auto& found : found_)
      boxes_.add(boxes.subspan(size_t{4} * found.cell).first<4>(), found.score,
                 static_cast<float>(found.class_index), found.cell);
    auto candidates = boxes_.take(input.width > 0 ? input : outputs_.layout.input);
    warn_once(boxes_.contradiction());
    return candidates;
  }

 private:
  ScoresAndBoxes outputs_;
  detection::DenseScores scores_;
  float threshold_;
  CornerBoxes boxes_;
  std::vector<detection::ScoredCell> found_;
};

Match fit_yolo_nas(const ModelSignature& model) {
  return find_scores_and_boxes(model) ? Match::Possible : Match::No;
}

std::unique_ptr<Head> open_yolo_nas(const ModelSignature& model, const HeadOptions& options) {
  const auto outputs = find_scores_and_boxes(model);
  if (!outputs) throw wrong_outputs(model, kYoloNas);
  return std::make_unique<YoloNas>(*outputs, unit_setting(options), options.threshold);
}

}  // namespace

const Family kFastestDet{.name = "fastestdet",
                         .aliases = "",
                         .tasks = kDetection,
                         .outputs = "1 tensor W:H:5+CLASSES, cells of 16 pixels",
                         .custom = "",
                         .threshold = 0.5f,
                         .fit = fit_fastest_det,
                         .open = open_fastest_det};

const Family kNanoDet{.name = "nanodet",
                      .aliases = "nanodet-plus",
                      .tasks = kDetection,
                      .outputs = "1 tensor CLASSES+32:N or N:CLASSES+32",
                      .custom = "",
                      .threshold = 0.35f,
                      .fit = fit_nano_det,
                      .open = open_nano_det};

const Family kYoloNas{
    .name = "yolo-nas",
    .aliases = "pp-yoloe,damo-yolo",
    .tasks = kDetection,
    .outputs = "scores CLASSES:N or N:CLASSES, and boxes 4:N of x1, y1, x2, y2 for each cell",
    .custom = "unit",
    .threshold = 0.25f,
    .fit = fit_yolo_nas,
    .open = open_yolo_nas};

}  // namespace weir::heads
