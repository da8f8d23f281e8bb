// The motion of tracked objects, and what all of them have in common when the camera moves.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <span>

#include "weir/detection.hpp"

namespace weir::track {

// BoxMotion: a Kalman filter that predicts where a box will be, at constant velocity.

// Centre, width and height with their velocities. The noise is that of DeepSORT and ByteTrack
// (arXiv 2110.06864): independent for each of the four, so that each is a filter of two states.
// Time is in steps of 1/30 s.
class BoxMotion {
 public:
  explicit BoxMotion(const Box& box) noexcept;
  // Advances by `steps`, which is not negative. `keep_size`: the size of a lost object stays.
  void predict(double steps, bool keep_size) noexcept;
  void shift(float x, float y) noexcept;  // what the camera did
  void correct(const Box& box) noexcept;
  Box box() const noexcept;
  // The squared Mahalanobis distance of a box from the prediction, as DeepSORT's equation 1.
  double distance(const Box& box) const noexcept;

 private:
  struct Axis {
    double value = 0, speed = 0;
    double vv = 0, vs = 0, ss = 0;  // covariance of value and speed
  };
  double scale() const noexcept;

  std::array<Axis, 4> axes_;  // x, y of the centre, width, height
};

// common_motion: how far the camera moved, from boxes alone.

struct Shift {
  float x = 0, y = 0;  // pixels
};

// The shift that brings the most predicted boxes onto boxes of nearly the same size: the median of
// those that agree. No shift where fewer than three agree or less than half of them do.
Shift common_motion(std::span<const Box> predicted, std::span<const Box> boxes);

}  // namespace weir::track
