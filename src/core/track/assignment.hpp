// Pairs tracks with boxes so that the sum of the pairs' costs is least.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace weir::track {

// A pair that may be formed; the lower the cost the better. Costs are finite and at most 1.
struct Candidate {
  uint32_t row = 0, column = 0;
  float cost = 0;
};

// Up to this many rows or columns that compete with each other, whichever is less, are paired
// optimally; more of them greedily, least cost first.
inline constexpr size_t kOptimalLimit = 256;

// Returns the chosen pairs; each row and each column is in at most one. As many pairs are formed as
// the least sum of costs allows, where leaving a row without a pair costs 1. Rows that compete for
// no column are solved apart (O(n^2 * m) for n rows and m columns that do).
std::vector<Candidate> assign(std::span<const Candidate> candidates);

}  // namespace weir::track
