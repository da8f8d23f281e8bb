// MediaPipe's palm detector: its anchors and its head, which is relative to them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/detection/candidate.hpp"

namespace weir::detection {

// Parts of the picture: centre and size.
struct Anchor {
  float x = 0, y = 0, width = 0, height = 0;
  bool operator==(const Anchor&) const = default;
};

struct PalmAnchorOptions {
  float least_scale = 1, greatest_scale = 1;
  float x_offset = 0.5f, y_offset = 0.5f;        // of a cell's centre, in cells
  std::vector<uint32_t> strides{8, 16, 16, 16};  // pixels of a cell, of each layer; above 0
};

// The anchors of a grid over 192 x 192 pixels. Adjacent layers of the same stride share a grid:
// each of its cells, row by row, has two anchors for every layer.
std::vector<Anchor> make_palm_anchors(const PalmAnchorOptions& options);

inline constexpr size_t kPalmRow = 18;  // y, x, height, width, then 7 key points

// Returns the anchors with a probability of at least `threshold`, in their order; class 0. Boxes
// that are not finite are left out. Preconditions: kPalmRow values in `boxes` for each score, and
// at least as many anchors.
Candidates decode_palms(std::span<const float> boxes, std::span<const float> scores,
                        std::span<const Anchor> anchors, float threshold, PictureSize picture);

}  // namespace weir::detection
