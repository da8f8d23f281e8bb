// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/evaluate/segmentation.hpp"

#include <cmath>
#include <map>

namespace weir::evaluate {

std::vector<ClassPixels> compare_class_maps(std::span<const uint32_t> truth,
                                            std::span<const uint32_t> found, uint32_t ignored) {
  std::map<uint32_t, ClassPixels> classes;
  for (size_t i = 0; i < truth.size(); ++i) {
    if (truth[i] == ignored) continue;
    ++classes[truth[i]].truth;
    if (found[i] != kNoPixelClass) ++classes[found[i]].found;
    if (found[i] == truth[i]) ++classes[truth[i]].both;
  }
  std::vector<ClassPixels> out;
  for (auto& [index, pixels] : classes) {
    pixels.class_index = index;
    out.push_back(pixels);
  }
  return out;
}

std::vector<double> overlap_of_classes(std::span<const std::vector<ClassPixels>> pictures,
                                       size_t classes, Times times) {
  std::vector<double> both(classes), either(classes);
  for (size_t p = 0; p < pictures.size(); ++p)
    for (const ClassPixels& pixels : pictures[p]) {
      if (pixels.class_index >= classes) continue;
      const double weight = count_times(times, p);
      both[pixels.class_index] += weight * static_cast<double>(pixels.both);
      either[pixels.class_index] +=
          weight * static_cast<double>(pixels.truth + pixels.found - pixels.both);
    }
  std::vector<double> out;
  for (size_t c = 0; c < classes; ++c) out.push_back(ratio(both[c], either[c]));
  return out;
}

Scores segmentation_scores(std::span<const std::vector<ClassPixels>> pictures, size_t classes,
                           Times times) {
  double sum = 0, occurring = 0, right = 0, all = 0;
  for (const double one : overlap_of_classes(pictures, classes, times)) {
    if (std::isnan(one)) continue;
    sum += one;
    occurring += 1;
  }
  for (size_t p = 0; p < pictures.size(); ++p)
    for (const ClassPixels& pixels : pictures[p]) {
      right += count_times(times, p) * static_cast<double>(pixels.both);
      all += count_times(times, p) * static_cast<double>(pixels.truth);
    }
  return {{"mean IoU", ratio(sum, occurring)}, {"pixel accuracy", ratio(right, all)}};
}

}  // namespace weir::evaluate
