// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/coordinates.hpp"
#include "core/tensor/geometry.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

namespace weir::heads {

Unit unit_setting(const HeadOptions& options) {
  const auto word = word_setting(options, "unit", {"pixels", "picture"});
  return !word ? Unit::Automatic : *word == 0 ? Unit::Pixels : Unit::Picture;
}

bool reaches(float score, float threshold) noexcept {
  return score > 0 && score >= threshold && std::isfinite(score);
}

void UnitOfNumbers::begin() noexcept {
  constexpr uint64_t kMany = 1 << 20;  // later objects count more than those long ago
  if (all_.objects > kMany) all_ = {all_.objects / 2, all_.beyond / 2};
  before_ = now_;
  frame_ = {};
  max_ = 0;
}

void UnitOfNumbers::add(std::span<const float> coordinates) noexcept {
  float max = 0;
  for (const float number : coordinates)
    if (std::isfinite(number)) max = std::max(max, std::abs(number));
  max_ = std::max(max_, max), stream_max_ = std::max(stream_max_, max);
  const bool is_beyond = max > kMaxOfPicture;
  for (Count* count : {&frame_, &all_}) ++count->objects, count->beyond += is_beyond;
}

Unit UnitOfNumbers::unit() noexcept {
  if (setting_ != Unit::Automatic) return now_ = setting_;
  if (all_.objects > 0) now_ = all_.is_in_pixels() ? Unit::Pixels : Unit::Picture;
  return now_;
}

std::optional<Error> UnitOfNumbers::contradiction() const {
  if (frame_.objects == 0 || setting_ == Unit::Cells) return std::nullopt;
  const bool is_set = setting_ != Unit::Automatic;
  const Unit found = frame_.is_in_pixels() ? Unit::Pixels : Unit::Picture;
  const Unit read = is_set ? setting_ : before_;
  if (read == Unit::Automatic || read == found) return std::nullopt;
  // Few objects may lie within the first two pixels.
  if (read == Unit::Pixels && (!is_set || !are_all_parts())) return std::nullopt;
  const char* const names[] = {"custom=unit:pixels", "custom=unit:picture"};
  char max[32];
  std::snprintf(max, sizeof max, "%g",
                static_cast<double>(read == Unit::Pixels ? stream_max_ : max_));
  return Error{
      .code = Code::SPEC_MISMATCH,
      .what = is_set ? "the coordinates contradict the setting unit"
                     : "the coordinates of a frame have another unit than before",
      .offered = std::string("coordinates up to ") + max + " of " +
                 std::to_string(read == Unit::Pixels ? all_.objects : frame_.objects) + " boxes",
      .needed = read == Unit::Picture ? "0 to 1 across the picture" : "pixels of the model's input",
      .fix = names[found == Unit::Picture]};
}

namespace {

// Left, top, right and bottom.
void clip(float width, float height, float (&edges)[4]) {
  for (size_t i = 0; i < 4; ++i) edges[i] = std::clamp(edges[i], 0.0f, i % 2 == 0 ? width : height);
}

}  // namespace

void CornerBoxes::add(std::span<const float, 4> box, float score, float class_index, size_t row) {
  constexpr float kMaxClasses = 1 << 24;
  // Class numbers of quantised outputs are between whole numbers: 1 is 0.996 for a scale of
  // 1/127.5.
  class_index = std::round(class_index);
  if (!reaches(score, threshold_) || !(class_index >= 0 && class_index < kMaxClasses)) return;
  if (!std::all_of(box.begin(), box.end(), [](float edge) { return std::isfinite(edge); })) return;
  numbers_.add(box);
  found_.push_back({.edges = {box[0], box[1], box[2], box[3]},
                    .score = score,
                    .class_index = static_cast<int32_t>(class_index),
                    .row = static_cast<uint32_t>(row)});
}

detection::Candidates CornerBoxes::take(Size input) {
  const bool are_parts = numbers_.unit() == Unit::Picture;
  if (are_parts && !found_.empty()) require_size(input);
  const auto width = static_cast<float>(input.width), height = static_cast<float>(input.height);
  const float right = are_parts ? 1 : width, bottom = are_parts ? 1 : height;
  const float scale_x = are_parts ? width : 1, scale_y = are_parts ? height : 1;
  const bool is_clipped = are_clipped_ && right > 0;
  detection::Candidates out;
  for (Found& found : found_) {
    auto& edges = found.edges;
    if (is_clipped) clip(right, bottom, edges);
    const detection::Candidate candidate{.x = edges[0] * scale_x,
                                         .y = edges[1] * scale_y,
                                         .width = (edges[2] - edges[0]) * scale_x,
                                         .height = (edges[3] - edges[1]) * scale_y,
                                         .score = found.score,
                                         .class_index = found.class_index,
                                         .row = found.row};
    if (candidate.is_finite()) out.push_back(candidate);
  }
  found_.clear();
  return out;
}

void require_size(Size input) {
  if (input.width > 0) return;
  throw Failure({.code = Code::SPEC_MISMATCH,
                 .what = "the size of the model's input is not known",
                 .offered = "coordinates relative to the size of the picture",
                 .needed = "the size, from tensor_preprocess, from a tensor_filter with a picture "
                           "input, or from custom=input",
                 .fix = "custom=input:640:640"});
}

}  // namespace weir::heads
