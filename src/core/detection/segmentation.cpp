// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/segmentation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/detection/best_class.hpp"

namespace weir::detection {

void classes_from_scores(std::span<const float> scores, size_t classes, float threshold,
                         std::span<uint16_t> out) noexcept {
  for (size_t i = 0; i < out.size(); ++i) {
    const auto row = scores.subspan(i * classes, classes);
    const float best = best_score(row);
    out[i] = best > threshold ? static_cast<uint16_t>(class_with(row, best)) : 0;
  }
}

void classes_from_planes(std::span<const float> scores, size_t classes, std::span<uint16_t> out) {
  constexpr size_t kBlock = 1024;  // pixels whose greatest scores stay in the cache
  std::array<float, kBlock> best;
  for (size_t first = 0; first < out.size(); first += kBlock) {
    const size_t count = std::min(kBlock, out.size() - first);
    std::fill_n(best.begin(), count, -std::numeric_limits<float>::infinity());
    std::fill_n(out.begin() + static_cast<ptrdiff_t>(first), count, uint16_t{0});
    for (size_t c = 0; c < classes; ++c) {
      const float* plane = scores.data() + c * out.size() + first;
      for (size_t i = 0; i < count; ++i) {
        const bool is_better = plane[i] > best[i];
        best[i] = is_better ? plane[i] : best[i];
        out[first + i] = is_better ? static_cast<uint16_t>(c) : out[first + i];
      }
    }
  }
}

std::optional<size_t> classes_from_numbers(std::span<const float> numbers, size_t classes,
                                           std::span<uint16_t> out) noexcept {
  const auto limit = static_cast<float>(classes);
  for (size_t i = 0; i < numbers.size(); ++i) {
    const float number = numbers[i];
    // False for NaN. Values above -1 are rounded to 0.
    if (!(number > -1 && number < limit)) return i;
    out[i] = static_cast<uint16_t>(static_cast<int32_t>(number));
  }
  return std::nullopt;
}

MaxDepth max_depth(std::span<const float> depths) noexcept {
  constexpr size_t kParts = 16;  // independent maxima, so that the loop is vectorised
  constexpr float kFinite = std::numeric_limits<float>::max();
  float parts[kParts] = {};
  uint32_t odd[kParts] = {};
  const auto add = [&](size_t part, float depth) {
    parts[part] = depth > parts[part] ? depth : parts[part];
    odd[part] |= !(std::abs(depth) <= kFinite);
  };
  size_t i = 0;
  for (; i + kParts <= depths.size(); i += kParts)
    for (size_t part = 0; part < kParts; ++part) add(part, depths[i + part]);
  for (; i < depths.size(); ++i) add(0, depths[i]);
  MaxDepth out{.value = *std::max_element(parts, parts + kParts)};
  if (std::any_of(odd, odd + kParts, [](uint32_t found) { return found != 0; }))
    out.not_finite = std::find_if_not(depths.begin(), depths.end(),
                                      [](float depth) { return std::isfinite(depth); }) -
                     depths.begin();
  return out;
}

void grays_from_depths(std::span<const float> depths, float max, std::span<uint8_t> out) noexcept {
  for (size_t i = 0; i < depths.size(); ++i) {
    const float scaled = depths[i] / max * 255;
    out[i] = static_cast<uint8_t>(static_cast<int32_t>(scaled > 0 ? scaled : 0));
  }
}

}  // namespace weir::detection
