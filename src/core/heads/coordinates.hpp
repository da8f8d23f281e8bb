// The unit of the coordinates that a detector gives.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

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

// Finds the unit by the coordinates of most objects of the stream: in pixels, some are beyond
// kMaxOfPicture unless the object is within the first two pixels.
class UnitOfNumbers {
 public:
  explicit UnitOfNumbers(Unit setting = Unit::Automatic) : setting_(setting) {}
  // Begins a frame.
  void begin() noexcept;
  // The coordinates of an object, or of a cell that may have one.
  void add(std::span<const float> coordinates) noexcept;
  // The setting, or else what the objects up to this frame say.
  Unit unit() noexcept;
  // After unit(): what this frame, or many objects in pixels, contradict: the setting or the
  // reading of earlier frames.
  std::optional<Error> contradiction() const;

 private:
  struct Count {
    uint64_t objects = 0, beyond = 0;
    bool is_in_pixels() const noexcept { return 2 * beyond >= objects; }
  };
  static constexpr float kMaxOfPicture = 2;
  // The coordinates of enough objects of the stream are those of parts of the picture.
  bool are_all_parts() const noexcept { return all_.objects >= 20 && stream_max_ <= 1.5f; }
  Unit setting_;
  Unit before_ = Unit::Automatic, now_ = Unit::Automatic;  // readings of the last two frames
  Count frame_, all_;
  float max_ = 0, stream_max_ = 0;  // of the frame and of the stream
};

// Collects the objects that a model gives by the edges of their boxes.
class CornerBoxes {
 public:
  // `are_clipped`: boxes end at the edges of the picture.
  CornerBoxes(Unit unit, float threshold, bool are_clipped = false)
      : numbers_(unit), threshold_(threshold), are_clipped_(are_clipped) {}
  void begin() noexcept { found_.clear(), numbers_.begin(); }
  // Adds an object unless its score is below the threshold, or a number is not one. `box`: x1, y1,
  // x2, y2. `class_index` below 0 is left out too.
  void add(std::span<const float, 4> box, float score, float class_index, size_t row);
  // The objects since begin(), in pixels of the model's input.
  detection::Candidates take(Size input);
  std::optional<Error> contradiction() const { return numbers_.contradiction(); }

 private:
  struct Found {
    float edges[4];  // left, top, right and bottom, in the model's unit
    float score;
    int32_t class_index;
    uint32_t row;
  };
  UnitOfNumbers numbers_;
  float threshold_;
  bool are_clipped_;
  std::vector<Found> found_;
};

// Whether a score makes a candidate: finite, above 0 and at least the threshold.
bool reaches(float score, float threshold) noexcept;

// Throws Failure (SPEC_MISMATCH) if coordinates are parts of a picture whose size is not known.
void require_size(Size input);

}  // namespace weir::heads
