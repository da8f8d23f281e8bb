// Metrics of classifiers: accuracy of the first and of the first five, confusion matrix.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "core/evaluate/scores.hpp"

namespace weir::evaluate {

inline constexpr size_t kNoClass = SIZE_MAX;  // a label that is none of the truth's classes

struct ClassifiedPicture {
  size_t truth = 0;
  std::vector<size_t> ranked;  // classes by falling score
};

// Parts of the pictures whose class is the first, and is among the first five; and the mean over
// the classes of the former.
Scores accuracy(std::span<const ClassifiedPicture> pictures, size_t classes, Times times);

// Counts of pictures: a row for each true class, a column for each class that came first, and a
// last column for those whose first class is none of them.
std::vector<std::vector<uint64_t>> confusion_matrix(std::span<const ClassifiedPicture> pictures,
                                                    size_t classes);

}  // namespace weir::evaluate
