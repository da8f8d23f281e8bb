// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/evaluate/classification.hpp"

#include <algorithm>

namespace weir::evaluate {

Scores accuracy(std::span<const ClassifiedPicture> pictures, size_t classes, Times times) {
  constexpr size_t kFirstFive = 5;
  std::vector<double> all(classes), right(classes);
  double pictures_counted = 0, first = 0, among_five = 0;
  for (size_t p = 0; p < pictures.size(); ++p) {
    const auto& [truth, ranked] = pictures[p];
    const double weight = count_times(times, p);
    const auto end = ranked.begin() + static_cast<ptrdiff_t>(std::min(ranked.size(), kFirstFive));
    const auto place = std::find(ranked.begin(), end, truth);
    pictures_counted += weight;
    all[truth] += weight;
    if (place == end) continue;
    among_five += weight;
    if (place != ranked.begin()) continue;
    first += weight;
    right[truth] += weight;
  }
  double sum = 0, occurring = 0;
  for (size_t c = 0; c < classes; ++c) {
    if (all[c] == 0) continue;
    sum += right[c] / all[c];
    occurring += 1;
  }
  return {{"top-1", ratio(first, pictures_counted)},
          {"top-5", ratio(among_five, pictures_counted)},
          {"mean of classes", ratio(sum, occurring)}};
}

std::vector<std::vector<uint64_t>> confusion_matrix(std::span<const ClassifiedPicture> pictures,
                                                    size_t classes) {
  std::vector<std::vector<uint64_t>> out(classes, std::vector<uint64_t>(classes + 1));
  for (const auto& [truth, ranked] : pictures) {
    const size_t first = ranked.empty() ? kNoClass : ranked.front();
    ++out[truth][std::min(first, classes)];
  }
  return out;
}

}  // namespace weir::evaluate
