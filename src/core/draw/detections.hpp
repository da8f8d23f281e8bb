// Detections: what a tensor of results says about a picture.
//
// A float32 tensor K:N is N rows of K numbers: x1, y1, x2, y2 (edges in pixels, x2 and y2 are the
// first beyond the box); from K = 5 on a score (0 or less: nobody); from K = 6 on the index of a
// class; then x, y of key points. Whole rows are those of weir/detection.hpp.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "weir/picture_map.hpp"

namespace weir::draw {

inline constexpr uint32_t kRowLimit = 10000;    // rows that are drawn
inline constexpr uint32_t kNumberLimit = 2048;  // of a row

struct Detection {
  double x1 = 0, y1 = 0, x2 = 0, y2 = 0;
  float score = 1;
  uint32_t class_index = 0;
};

// Rows of one tensor that are not among its detections, and key points that are not finite.
struct LeftOut {
  uint64_t nobody = 0;
  uint64_t not_finite = 0;    // a number of box, score or class
  uint64_t without_area = 0;  // x2 <= x1 or y2 <= y1
  uint64_t beyond_limit = 0;
  uint64_t points_not_finite = 0;
};

struct Detections {
  std::vector<Detection> rows;
  std::vector<Point> points;  // points_per_row for each row; those not finite stay in their place
  size_t points_per_row = 0;
  bool scored = false;
  // Of the picture that coordinates are of; 0: the picture that is drawn on.
  uint32_t picture_width = 0, picture_height = 0;
  LeftOut left_out;
};

// SPEC_MISMATCH unless it is float32 K:N (further dimensions of 1) with K 4, 5, 6 or 6 and a pair
// for each key point.
Status check_detections(const TensorSpec& spec);
// Precondition: check_detections(); `bytes` are the tensor's, any alignment. `maps` lead from the
// tensor's coordinates to the picture's: none, one, or one for each row (SPEC_MISMATCH else). A box
// stays upright: what is turned becomes the smallest box around it.
Result<Detections> read_detections(const TensorSpec& spec, std::span<const std::byte> bytes,
                                   std::span<const PictureMap> maps);

}  // namespace weir::draw
