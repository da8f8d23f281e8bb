// Reads boxes and class scores of YOLO models.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/yolo_heads.hpp"

#include "core/detection/best_class.hpp"

namespace weir::heads {
namespace {

constexpr size_t kBox = 4;

// Cells of the three grids, of 8, 16 and 32 pixels.
size_t cells_of(detection::PictureSize input) {
  size_t cells = 0;
  for (const uint32_t stride : {8u, 16u, 32u})
    cells += size_t{input.width / stride} * (input.height / stride);
  return cells;
}

// The dimension of the only output that counts cells: 0 or 1; nullopt if neither does.
std::optional<size_t> cell_dimension(const ModelFacts& model) {
  if (model.outputs.size() != 1 || model.outputs[0].shape.min_rank() != 2) return std::nullopt;
  const Shape& shape = model.outputs[0].shape;
  const size_t cells = cells_of(model.input);
  for (const size_t dimension : {0u, 1u})
    if (cells > 0 && shape[dimension] == cells && shape[1 - dimension] > kBox) return dimension;
  return std::nullopt;
}

class Yolov8 final : public Head {
 public:
  Yolov8(const ModelFacts& model, const HeadOptions& options, size_t cell_dimension)
      : threshold_(options.threshold),
        cells_(model.outputs[0].shape[cell_dimension]),
        values_(model.outputs[0].shape[1 - cell_dimension]),
        cells_are_inner_(cell_dimension == 0) {}

  results::Features features() const override { return {}; }
  Suppression suppression() const noexcept override { return Suppression::ByClass; }

  detection::Candidates find(OutputValues& outputs, detection::PictureSize) override {
    const auto all = outputs.read(0);
    const auto at = [&](size_t cell, size_t value) {
      return cells_are_inner_ ? all[value * cells_ + cell] : all[cell * values_ + value];
    };
    detection::Candidates found;
    for (size_t cell = 0; cell < cells_; ++cell) {
      size_t best = kBox;
      for (size_t value = kBox + 1; value < values_; ++value)
        if (at(cell, value) > at(cell, best)) best = value;
      const float score = at(cell, best);
      if (!(score >= threshold_)) continue;
      const float width = at(cell, 2), height = at(cell, 3);
      const detection::Candidate candidate{.x = at(cell, 0) - width / 2,
                                           .y = at(cell, 1) - height / 2,
                                           .width = width,
                                           .height = height,
                                           .score = score,
                                           .class_index = static_cast<int32_t>(best - kBox),
                                           .row = static_cast<uint32_t>(cell)};
      if (candidate.is_finite()) found.push_back(candidate);
    }
    return found;
  }

 private:
  float threshold_;
  size_t cells_, values_;
  bool cells_are_inner_;
};

Fit fit(const ModelFacts& model) {
  return cell_dimension(model) ? Fit::Possible : Fit::No;
}

std::unique_ptr<Head> open(const ModelFacts& model, const HeadOptions& options) {
  const auto dimension = cell_dimension(model);
  if (!dimension)
    throw Failure({.code = Code::SPEC_MISMATCH,
                   .what = "the outputs are not those of YOLOv8",
                   .offered = model.describe_outputs(),
                   .needed = std::string(kYolov8.outputs)});
  return std::make_unique<Yolov8>(model, options, *dimension);
}

}  // namespace

const Family kYolov8{.name = "yolov8",
                     .aliases = "yolov9,yolov11,yolov12",
                     .tasks = kDetection,
                     .outputs = "1 tensor N:4+CLASSES or 4+CLASSES:N",
                     .custom = "",
                     .threshold = 0.25f,
                     .fit = fit,
                     .open = open};

}  // namespace weir::heads
