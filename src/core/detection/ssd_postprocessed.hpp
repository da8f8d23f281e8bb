// SSD models whose graph ends in TFLite_Detection_PostProcess: boxes are decoded and suppressed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>

#include "core/detection/candidate.hpp"

namespace weir::detection {

struct PostprocessedSsd {
  std::span<const float> boxes;  // ymin, xmin, ymax, xmax of each row, as parts of the picture
  std::span<const float> classes, scores;  // one of each row
  float count = 0;                         // rows that are detections
};

// Returns the rows with a score of at least `threshold`, in their order, clamped to the picture.
// Rows with values that are not finite are left out. Precondition: as many classes and boxes as
// scores.
Candidates decode(const PostprocessedSsd& head, float threshold, PictureSize picture);

}  // namespace weir::detection
