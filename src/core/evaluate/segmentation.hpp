// Metrics of class maps: intersection over union of each class, and the part of right pixels.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/evaluate/scores.hpp"

namespace weir::evaluate {

// Pixels of a class in a picture: those that are of it in the truth, those that were found as it,
// and those that are both.
struct ClassPixels {
  uint32_t class_index = 0;
  uint64_t truth = 0, found = 0, both = 0;
};

inline constexpr uint32_t kNoPixelClass = UINT32_MAX;  // found as no class

// Counts the pixels of two maps of equal size. Pixels whose truth is `ignored` do not count.
std::vector<ClassPixels> compare_class_maps(std::span<const uint32_t> truth,
                                            std::span<const uint32_t> found, uint32_t ignored);

// IoU of each class over all pictures, which counts pixels and not pictures; undefined for those
// that occur neither in the truth nor in what was found.
std::vector<double> overlap_of_classes(std::span<const std::vector<ClassPixels>> pictures,
                                       size_t classes, Times times);
// The mean of these over the classes that occur, and the part of the pixels whose class is right.
Scores segmentation_scores(std::span<const std::vector<ClassPixels>> pictures, size_t classes,
                           Times times);

}  // namespace weir::evaluate
