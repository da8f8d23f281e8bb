// The unit of the coordinates that a detector gives.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>

#include "core/heads/head_options.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::heads {

enum class Unit {
  Automatic,
  Pixels,   // of the model's input
  Picture,  // 0 to 1 across the picture
  Cells     // relative to the cell, in its size; width and height as logarithms
};

// custom=unit:pixels|picture.
Unit unit_setting(const HeadOptions& options);

// Tells pixels from parts of the picture by the coordinates themselves: in pixels, one of them is
// beyond kMaxOfPicture unless all objects are within the first two pixels.
class UnitOfNumbers {
 public:
  void add(float coordinate) noexcept {
    if (coordinate > kMaxOfPicture || coordinate < -kMaxOfPicture) is_beyond_ = true;
  }
  Unit unit() const noexcept { return is_beyond_ ? Unit::Pixels : Unit::Picture; }

 private:
  static constexpr float kMaxOfPicture = 2;
  bool is_beyond_ = false;
};

// Collects the objects that a model gives by the edges of their boxes.
class CornerBoxes {
 public:
  CornerBoxes(Unit unit, float threshold) : unit_(unit), threshold_(threshold) {}
  void begin() noexcept { found_.clear(), numbers_ = {}; }
  // Adds an object unless its score is below the threshold, or a number is not one. `box`: x1, y1,
  // x2, y2. `class_index` below 0 is left out too.
  void add(std::span<const float, 4> box, float score, float class_index, size_t row);
  // The objects since begin(), in pixels of the model's input.
  detection::Candidates take(Size input);

 private:
  Unit unit_;
  float threshold_;
  UnitOfNumbers numbers_;
  detection::Candidates found_;
};

// Whether a score makes a candidate: finite, above 0 and at least the threshold.
bool reaches(float score, float threshold) noexcept;

// Throws Failure (SPEC_MISMATCH) if coordinates are parts of a picture whose size is not known.
void require_size(Size input);

}  // namespace weir::heads
