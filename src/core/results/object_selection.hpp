// Chooses which candidates of a frame become objects.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <vector>

#include "core/detection/candidate.hpp"

namespace weir::results {

enum class SuppressionScope {
  None,       // no candidate suppresses another one
  SameClass,  // candidates of the same class do
  AnyClass,
  SameClassRotated  // by the overlap of boxes with an angle
};

struct Selection {
  SuppressionScope rivals = SuppressionScope::SameClass;
  float max_overlap = 0.45f;  // intersection over union
  size_t max_objects = 100;
  std::span<const int32_t> classes{};  // that are kept; empty = all
};

// Greedy non-maximum suppression, best score first, ties by order. Stops at max_objects, so it
// takes candidates * max_objects steps at most. Rotated boxes have their centre at x, y
// (Candidate); others their top left corner.
detection::Candidates select(detection::Candidates candidates, const Selection& selection);

// Intersection over union of two boxes with an angle, from the polygon that they have in common.
float rotated_overlap(const detection::Candidate& a, const detection::Candidate& b) noexcept;

}  // namespace weir::results
