// Searches the cells of a detection head for those with a class of a high score.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace weir::detection {

// Where the scores of a head are. A head has `values` numbers for each of `cells` cells, in one of
// two orders of memory: all numbers of a cell together, or all cells of a number together.
struct DenseScores {
  size_t cells = 0, values = 0;
  bool cells_are_inner = false;  // all cells of a number together
  size_t first_class = 0;        // index of the number of class 0
  size_t classes = 0;            // at least 1
  bool has_objectness = false;   // the number before class 0 multiplies those of the classes

  size_t at(size_t cell, size_t value) const noexcept {
    return cells_are_inner ? value * cells + cell : cell * values + value;
  }
};

struct ScoredCell {
  uint32_t cell = 0;
  int32_t class_index = 0;
  float score = 0;
  bool operator==(const ScoredCell&) const = default;
};

// Appends the cells whose score is finite, above 0 and at least `threshold`, in their order. The
// score is that of the best class, the first of equal ones, times the objectness. Probabilities of
// classes are at most 1: a cell with a lower objectness than `threshold` is not looked at further.
// Precondition: `numbers` has cells * values elements.
void find_scored_cells(std::span<const float> numbers, const DenseScores& scores, float threshold,
                       std::vector<ScoredCell>* found);

}  // namespace weir::detection
