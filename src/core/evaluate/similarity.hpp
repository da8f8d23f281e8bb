// How alike two objects are: overlap of boxes (IoU), object key point similarity (OKS).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <vector>

#include "core/evaluate/objects.hpp"

namespace weir::evaluate {

// Intersection over union of two boxes, 0 to 1; 0 where both are empty.
double overlap(const Rectangle& a, const Rectangle& b) noexcept;
// The part of `found` that is in a crowd's box.
double part_in_crowd(const Rectangle& found, const Rectangle& crowd) noexcept;

// COCO's deviation of each of the 17 key points of a person, relative to the object's size. For
// another number of points, which COCO does not define, each point has 1 / `points`.
std::vector<double> key_point_deviations(size_t points);

// The object key point similarity of COCO: the mean over the labelled points of the truth of
// exp(-d^2 / (2 area (2 sigma)^2)). If no point is labelled, distances are to the box of twice the
// truth's size about its centre.
double key_point_similarity(const TruthObject& truth, const FoundObject& found,
                            std::span<const double> deviations) noexcept;

}  // namespace weir::evaluate
