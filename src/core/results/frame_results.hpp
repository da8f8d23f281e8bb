// FrameResults: what a network found in one frame, before it is written as tensors
// (weir/results.h).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "weir/detection.hpp"

namespace weir::results {

struct KeyPoint {
  float x = 0, y = 0;  // pixels
  float score = 0;
  bool operator==(const KeyPoint&) const = default;
};

struct Object {
  Box box{};        // pixels
  float score = 0;  // above 0
  int32_t class_index = 0;
  uint32_t track = 0;
  int32_t parent = -1;
  float rotation = 0;  // of the box about its centre, clockwise, in radians
  bool operator==(const Object&) const = default;
};

// The tables that belong to the rows are empty or complete: `masks` has mask_width * mask_height
// bytes, `class_scores` has n_classes numbers, `texts` has one text for each object.
struct FrameResults {
  std::vector<Object> objects;
  size_t points_per_object = 0;
  std::vector<KeyPoint> points;  // of all objects, in their order

  uint32_t mask_width = 0, mask_height = 0;
  std::vector<uint8_t> masks;  // probabilities, 0 to 255, over each object's box; row after row

  size_t n_classes = 0;
  std::vector<float> class_scores;
  std::vector<std::string> texts;

  uint32_t map_width = 0, map_height = 0;  // of class_map or depth
  std::vector<uint16_t> class_map;
  std::vector<float> depth;

  void clear() noexcept;  // keeps the memory
};

// What a stream of results contains; it does not change from frame to frame.
struct Features {
  bool has_boxes = true;
  size_t points_per_object = 0;
  bool has_masks = false, has_class_scores = false, has_texts = false;
  bool has_class_map = false, has_depth = false;
  bool operator==(const Features&) const = default;
};

}  // namespace weir::results
