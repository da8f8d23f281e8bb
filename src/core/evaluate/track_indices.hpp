// The tracks of a sequence as indices, and the overlaps of its boxes, which all metrics of trackers
// use.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <vector>

#include "core/evaluate/tracking.hpp"
#include "core/track/assignment.hpp"

namespace weir::evaluate {

// Boxes with an overlap of at least this much may be matched by MOTA and IDF1.
inline constexpr double kMinOverlap = 0.5;

struct IndexedFrame {
  std::vector<size_t> truth, found;  // tracks of the boxes, from 0
  track::Matrix overlaps;            // a row for each box of the truth
};

struct IndexedSequence {
  std::vector<IndexedFrame> frames;
  std::vector<size_t> truth_lengths, found_lengths;  // frames of each track
};

IndexedSequence index_tracks(const Sequence& sequence);

}  // namespace weir::evaluate
