// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/dense_head.hpp"
#include "core/tensor/geometry.hpp"

#include <algorithm>
#include <cmath>

namespace weir::heads {
namespace {

using detection::Candidate;
using detection::Candidates;

constexpr size_t kBox = 4;
constexpr size_t kSamples = 64;  // cells that are looked at to find the unit

}  // namespace

DenseHead::DenseHead(DenseSpec spec, float threshold)
    : spec_(std::move(spec)),
      scores_{.cells = spec_.layout.rows,
              .values = spec_.layout.values,
              .cells_are_inner = spec_.layout.rows_are_inner,
              .first_class = kBox + (spec_.has_objectness ? 1 : 0),
              .classes = spec_.classes,
              .has_objectness = spec_.has_objectness},
      threshold_(threshold),
      numbers_(spec_.unit) {}

results::Features DenseHead::features() const {
  return {.points_per_object = spec_.points, .has_masks = spec_.prototypes.has_value()};
}

Suppression DenseHead::suppression() const noexcept {
  return spec_.has_angle ? Suppression::Rotated : Suppression::ByClass;
}

Size DenseHead::known(Size input) const noexcept {
  return input.width > 0 ? input : spec_.layout.input;
}

std::span<const float> DenseHead::read(OutputValues& outputs) const {
  const auto numbers = outputs.read(spec_.output);
  if (numbers.size() == scores_.cells * scores_.values) return numbers;
  throw Failure({.code = Code::SPEC_MISMATCH,
                 .what = "the frame has a different number of cells than the head was opened for",
                 .offered = std::to_string(numbers.size()) + " numbers",
                 .needed = std::to_string(scores_.cells * scores_.values)});
}

std::span<const CellPlace> DenseHead::places(Size input) {
  if (input != placed_ || places_.empty()) {
    places_ = cell_places(spec_.layout, input);
    placed_ = input;
  }
  return places_;
}

// Which reading of the centres is nearest to the cells they belong to. Cells of zeros say nothing.
Unit DenseHead::unit_of_grid(std::span<const float> numbers, Size input) {
  const auto where = places(input);
  double pixels = 0, parts = 0, cells = 0;  // distances
  const auto add = [&](size_t cell) {
    const CellPlace& place = where[cell % where.size()];
    const float x = numbers[scores_.at(cell, 0)], y = numbers[scores_.at(cell, 1)];
    const float width = numbers[scores_.at(cell, 2)];
    if (!std::isfinite(x) || !std::isfinite(y) || (x == 0 && y == 0 && width == 0)) return;
    const auto stride = static_cast<double>(place.stride);
    const double column = place.column + 0.5, row = place.row + 0.5;
    pixels += std::abs(x / stride - column) + std::abs(y / stride - row);
    parts += std::abs(x * static_cast<float>(input.width) / stride - column) +
             std::abs(y * static_cast<float>(input.height) / stride - row);
    cells += std::abs(x - 0.5) + std::abs(y - 0.5);
  };
  for (const auto& found : found_) add(found.cell);
  for (size_t i = 0; i < kSamples; ++i) add(i * scores_.cells / kSamples);
  return cells < std::min(pixels, parts) ? Unit::Cells
         : parts < pixels                ? Unit::Picture
                                         : Unit::Pixels;
}

Unit DenseHead::choose_unit(std::span<const float> numbers, Size input) {
  if (spec_.unit == Unit::Automatic && spec_.may_be_cells && !places(input).empty())
    return unit_of_grid(numbers, input);
  numbers_.begin();
  const auto add = [&](size_t cell) {
    const float centre[] = {numbers[scores_.at(cell, 0)], numbers[scores_.at(cell, 1)]};
    const bool is_empty = centre[0] == 0 && centre[1] == 0 && numbers[scores_.at(cell, 2)] == 0;
    if (!is_empty) numbers_.add(centre);
  };
  for (const auto& found : found_) add(found.cell);
  for (size_t i = 0; i < kSamples; ++i) add(i * scores_.cells / kSamples);
  const Unit unit = numbers_.unit();
  warn_once(numbers_.contradiction());
  return unit;
}

Candidate DenseHead::make_candidate(const detection::ScoredCell& found,
                                    std::span<const float> numbers,
                                    std::span<const CellPlace> where) const {
  const auto number = [&](size_t value) { return numbers[scores_.at(found.cell, value)]; };
  float x = number(0) * scale_.x, y = number(1) * scale_.y;
  float width = number(2) * scale_.x, height = number(3) * scale_.y;
  if (!where.empty()) {
    const CellPlace& place = where[found.cell % where.size()];
    const auto stride = static_cast<float>(place.stride);
    x = (x + static_cast<float>(place.column)) * stride;
    y = (y + static_cast<float>(place.row)) * stride;
    width = std::exp(width) * stride;
    height = std::exp(height) * stride;
  }
  return {.x = spec_.has_angle ? x : x - width / 2,
          .y = spec_.has_angle ? y : y - height / 2,
          .width = width,
          .height = height,
          .score = found.score,
          .class_index = found.class_index,
          .row = found.cell,
          .angle = spec_.has_angle ? number(scores_.values - 1) : 0};
}

Candidates DenseHead::find(OutputValues& outputs, Size frame_input) {
  const Size input = known(frame_input);
  const auto numbers = read(outputs);
  found_.clear();
  detection::find_scored_cells(numbers, scores_, threshold_, &found_);
  Candidates candidates;
  if (found_.empty()) return candidates;
  const Unit unit = choose_unit(numbers, input);
  scale_ = {};
  if (unit == Unit::Picture) {
    require_size(input);
    scale_ = {static_cast<float>(input.width), static_cast<float>(input.height)};
  }
  const auto where = unit == Unit::Cells ? places(input) : std::span<const CellPlace>();
  if (unit == Unit::Cells && where.empty()) require_size({});
  candidates.reserve(found_.size());
  for (const auto& found : found_) {
    const Candidate candidate = make_candidate(found, numbers, where);
    if (candidate.is_finite()) candidates.push_back(candidate);
  }
  return candidates;
}

void DenseHead::complete(OutputValues& outputs, std::span<const Candidate> kept, Size frame_input,
                         results::FrameResults* results) {
  if (kept.empty()) return;
  const auto numbers = read(outputs);
  if (spec_.points > 0) add_points(numbers, kept, results);
  if (spec_.prototypes) add_masks(outputs, numbers, kept, known(frame_input), results);
}

void DenseHead::add_points(std::span<const float> numbers, std::span<const Candidate> kept,
                           results::FrameResults* results) const {
  const size_t first = scores_.first_class + scores_.classes;
  const auto finite = [](float number) { return std::isfinite(number); };
  for (const Candidate& candidate : kept)
    for (size_t i = 0; i < spec_.points; ++i) {
      const auto number = [&](size_t value) {
        return numbers[scores_.at(candidate.row, first + i * spec_.point_length + value)];
      };
      const float x = number(0) * scale_.x, y = number(1) * scale_.y;
      const float score = spec_.point_length == 3 ? number(2) : 1;
      const bool is_good = finite(x) && finite(y) && finite(score);
      results->points.push_back(is_good ? results::KeyPoint{x, y, score} : results::KeyPoint{});
    }
}

// All masks have the size of the largest box in cells of the prototypes.
void DenseHead::add_masks(OutputValues& outputs, std::span<const float> numbers,
                          std::span<const Candidate> kept, Size input,
                          results::FrameResults* results) {
  const PrototypeFacts& facts = *spec_.prototypes;
  require_size(input);
  const auto values = outputs.read(facts.output);
  if (values.size() != facts.width * facts.height * facts.count)
    throw Failure({.code = Code::SPEC_MISMATCH,
                   .what = "the prototype masks have another size than the head was opened for",
                   .offered = std::to_string(values.size()) + " numbers",
                   .needed = std::to_string(facts.width * facts.height * facts.count)});
  const float to_x = static_cast<float>(facts.width) / static_cast<float>(input.width);
  const float to_y = static_cast<float>(facts.height) / static_cast<float>(input.height);
  float width = 1, height = 1;
  for (const Candidate& candidate : kept) {
    width = std::max(width, std::ceil(candidate.width * to_x));
    height = std::max(height, std::ceil(candidate.height * to_y));
  }
  results->mask_width = static_cast<uint32_t>(std::min(width, static_cast<float>(facts.width)));
  results->mask_height = static_cast<uint32_t>(std::min(height, static_cast<float>(facts.height)));
  const size_t bytes = size_t{results->mask_width} * results->mask_height;
  results->masks.resize(kept.size() * bytes);
  std::vector<float> weights(facts.count);
  const size_t first = scores_.first_class + scores_.classes;
  for (size_t i = 0; i < kept.size(); ++i) {
    const Candidate& candidate = kept[i];
    for (size_t k = 0; k < weights.size(); ++k)
      weights[k] = numbers[scores_.at(candidate.row, first + k)];
    const Box box{candidate.x * to_x, candidate.y * to_y, (candidate.x + candidate.width) * to_x,
                  (candidate.y + candidate.height) * to_y};
    masks_.draw({values, facts.width, facts.height, facts.count, facts.are_packed}, weights, box,
                results->mask_width, results->mask_height,
                std::span(results->masks).subspan(i * bytes, bytes));
  }
}

}  // namespace weir::heads
