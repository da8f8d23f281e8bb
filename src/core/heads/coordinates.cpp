// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/coordinates.hpp"
#include "core/tensor/geometry.hpp"

#include <cmath>
#include <utility>

namespace weir::heads {

Unit unit_setting(const HeadOptions& options) {
  const auto word = word_setting(options, "unit", {"pixels", "picture"});
  return !word ? Unit::Automatic : *word == 0 ? Unit::Pixels : Unit::Picture;
}

bool reaches(float score, float threshold) noexcept {
  return score > 0 && score >= threshold && std::isfinite(score);
}

void CornerBoxes::add(std::span<const float, 4> box, float score, float class_index, size_t row) {
  constexpr float kMaxClasses = 1 << 24;
  // Class numbers of quantised outputs are between whole numbers: 1 is 0.996 for a scale of
  // 1/127.5.
  class_index = std::round(class_index);
  if (!reaches(score, threshold_) || !(class_index >= 0 && class_index < kMaxClasses)) return;
  const detection::Candidate candidate{.x = box[0],
                                       .y = box[1],
                                       .width = box[2] - box[0],
                                       .height = box[3] - box[1],
                                       .score = score,
                                       .class_index = static_cast<int32_t>(class_index),
                                       .row = static_cast<uint32_t>(row)};
  if (!candidate.is_finite()) return;
  for (const float edge : box) numbers_.add(edge);
  found_.push_back(candidate);
}

detection::Candidates CornerBoxes::take(Size input) {
  const Unit unit = unit_ == Unit::Automatic ? numbers_.unit() : unit_;
  if (unit == Unit::Picture && !found_.empty()) {
    require_size(input);
    const auto width = static_cast<float>(input.width), height = static_cast<float>(input.height);
    for (detection::Candidate& candidate : found_) {
      candidate.x *= width, candidate.width *= width;
      candidate.y *= height, candidate.height *= height;
    }
  }
  return std::exchange(found_, {});
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
