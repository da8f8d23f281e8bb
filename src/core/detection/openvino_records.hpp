// Outputs of OpenVINO's person and face detectors: records of picture, class, score and box.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>

#include "core/detection/candidate.hpp"

namespace weir::detection {

inline constexpr size_t kOpenvinoRecord = 7;

// Reads records of picture index, class, score, xmin, ymin, xmax, ymax (0 to 1 across the picture)
// up to the first with a negative picture index. Returns those with a score of at least
// `threshold`, in their order. Records that are not finite are left out.
Candidates decode_openvino(std::span<const float> records, float threshold, PictureSize picture);

}  // namespace weir::detection
