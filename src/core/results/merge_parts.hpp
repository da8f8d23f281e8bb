// Merges the objects that a network found in overlapping parts of one picture.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <span>

#include "core/results/frame_results.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::results {

struct PictureParts {
  std::span<const Box> boxes;         // of each part, in the picture
  std::span<const uint32_t> part_of;  // for each object
  Size picture;                       // 0 x 0: not known
};

// Removes objects that another part has too: boxes of the same class with more than `max_overlap`
// in common, intersection over union, or over the smaller box if an edge of its part cuts it,
// unless that is an edge of the picture. What stays has the higher score, and the box around both
// if an edge cuts it too and the results have no masks. Keeps the best `max_objects`, best first.
void merge_parts(const PictureParts& parts, float max_overlap, size_t max_objects,
                 FrameResults* results);

// Whether the parts are tiles of a picture: two or more, in rows that cover its width and together
// its height, within a pixel. False if its size is not known (0 x 0).
bool are_tiles(std::span<const Box> parts, Size picture);

}  // namespace weir::results
