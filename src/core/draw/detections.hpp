// Detections: reads boxes and key points from a tensor of results.
//
// A float32 tensor K:N is N rows of K numbers: x1, y1, x2, y2 (edges in pixels; x2 and y2 are the
// first pixel after the box); for K >= 5 a score (0 or less: background); for K >= 6 a class index;
// then x, y of key points. weir/detection.hpp defines complete rows.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "weir/source_map.hpp"

namespace weir::draw {

inline constexpr uint32_t kRowLimit = 10000;    // rows that are drawn
inline constexpr uint32_t kNumberLimit = 2048;  // numbers in a row

struct Detection {
  double x1 = 0, y1 = 0, x2 = 0, y2 = 0;
  float score = 1;
  uint32_t class_index = 0;
};

// Counts rows of one tensor that are not detections, and key points that are not finite.
struct LeftOut {
  uint64_t background = 0;
  uint64_t not_finite = 0;    // a number of box, score or class
  uint64_t without_area = 0;  // x2 <= x1 or y2 <= y1
  uint64_t beyond_limit = 0;
  uint64_t points_not_finite = 0;
};

struct Detections {
  std::vector<Detection> rows;
  // points_per_row for each row; points that are not finite keep their place.
  std::vector<Point> points;
  size_t points_per_row = 0;
  bool scored = false;
  // The size of the picture that coordinates refer to; 0: the picture that is drawn on.
  uint32_t picture_width = 0, picture_height = 0;
  LeftOut left_out;
};

// SPEC_MISMATCH unless the tensor is float32 K:N (further dimensions of 1), where K is 4, 5, 6 or 6
// plus two for each key point.
Status check_detections(const TensorSpec& spec);
// Precondition: check_detections(). `bytes` are the tensor's and may have any alignment. `maps`
// lead from tensor to picture coordinates: none, one, or one for each row (else SPEC_MISMATCH). A
// rotated box becomes its axis-aligned bounding box.
Result<Detections> read_detections(const TensorSpec& spec, std::span<const std::byte> bytes,
                                   std::span<const SourceMap> maps);

}  // namespace weir::draw
