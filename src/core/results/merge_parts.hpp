// Merges the objects that a network found in overlapping parts of one picture.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <span>

#include "core/results/frame_results.hpp"

namespace weir::results {

struct PictureParts {
  std::span<const Box> boxes;         // of each part, in the picture
  std::span<const uint32_t> part_of;  // for each object
};

// Removes objects that another part has too: boxes of the same class with more than `max_overlap`
// in common, intersection over union, or over the smaller box if an edge of its part cuts one of
// them. What stays has the higher score, and the box around both if an edge cuts it too and the
// results have no masks. Keeps the best `max_objects`, best first.
void merge_parts(const PictureParts& parts, float max_overlap, size_t max_objects,
                 FrameResults* results);

}  // namespace weir::results
