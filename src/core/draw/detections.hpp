// Detections: reads boxes and key points from a tensor of results.
//
// A float32 tensor K:N is N rows of K numbers: x1, y1, x2, y2 (edges in pixels; x2 and y2 are the
// first pixel after the box); for K >= 5 a score (0 or less: background); for K >= 6 a class index;
// then x, y of key points. weir/detection.hpp defines complete rows.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "core/zone/zone.hpp"
#include "weir/source_map.hpp"

namespace weir::draw {

inline constexpr uint32_t kRowLimit = 10000;    // rows that are drawn
inline constexpr uint32_t kNumberLimit = 2048;  // numbers in a row

struct Detection {
  double x1 = 0, y1 = 0, x2 = 0, y2 = 0;
  float score = 1;
  uint32_t class_index = 0;
  uint32_t source = 0;    // which list of names its class belongs to
  uint32_t track = 0;     // 0 = none
  float rotation = 0;     // of the box about its centre, clockwise, in radians
  int32_t mask = -1;      // index in Detections::masks; -1 = none
  int32_t text = -1;      // index in Detections::texts, written instead of a class name; -1 = none
  bool is_label = false;  // of the whole picture, or of the box of another row: only written
};

// Probabilities 0 to 255 over the box of a detection, row after row.
struct DetectionMask {
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> values;
};

// The class of each element of a grid over a box of the picture; class 0 is background. Of depths
// the level, 0 to 255: the picture is painted over with them.
struct ClassMap {
  double x1 = 0, y1 = 0, x2 = 0, y2 = 0;
  uint32_t width = 0, height = 0;
  std::vector<uint16_t> classes;
  bool is_depth = false;
};

// Counts rows of one tensor that are not detections, and key points that are not finite.
struct LeftOut {
  uint64_t background = 0;
  uint64_t not_finite = 0;    // a number of box, score or class
  uint64_t without_area = 0;  // x2 <= x1 or y2 <= y1
  uint64_t beyond_limit = 0;
  uint64_t points_not_finite = 0;
};

// Names of classes, of each source of results.
using ClassNames = std::vector<std::vector<std::string>>;

// What was counted in a zone; NaN = not known.
struct ZoneTotal {
  float inside = NAN, entered = NAN;    // of an area
  float forward = NAN, backward = NAN;  // of a line
};

struct Detections {
  std::vector<Detection> rows;
  // points_per_row for each row; points that are not finite keep their place.
  std::vector<Point> points;
  size_t points_per_row = 0;
  std::vector<float> point_scores;  // as many as points, or none: all are 1
  std::vector<DetectionMask> masks;
  std::vector<std::string> texts;
  std::vector<ClassMap> class_maps;
  std::shared_ptr<const ClassNames> names;     // that came with the results; null: none did
  std::shared_ptr<const zone::ZoneSet> zones;  // of the stream; null: it has none
  std::vector<ZoneTotal> zone_totals;          // by number of the zone; may be shorter
  bool scored = false;
  // The size of the picture that coordinates refer to; 0: the picture that is drawn on.
  uint32_t picture_width = 0, picture_height = 0;
  LeftOut left_out;

  bool has_zones() const noexcept { return zones && !zones->zones.empty(); }
  bool empty() const noexcept { return rows.empty() && class_maps.empty() && !has_zones(); }
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
