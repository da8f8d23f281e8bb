// Searches rows one by one, and planes in blocks of cells that stay in the cache.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/dense_scores.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/detection/best_class.hpp"

namespace weir::detection {
namespace {

constexpr size_t kBlock = 512;  // cells

void append(size_t cell, int32_t class_index, float score, float threshold,
            std::vector<ScoredCell>* found) {
  if (score > 0 && score >= threshold && std::isfinite(score))
    found->push_back({static_cast<uint32_t>(cell), class_index, score});
}

void find_in_rows(std::span<const float> numbers, const DenseScores& scores, float threshold,
                  std::vector<ScoredCell>* found) {
  for (size_t cell = 0; cell < scores.cells; ++cell) {
    const float* row = numbers.data() + cell * scores.values;
    const float objectness = scores.has_objectness ? row[scores.first_class - 1] : 1;
    if (!(objectness >= threshold)) continue;
    const std::span classes(row + scores.first_class, scores.classes);
    const float best = best_score(classes);
    if (best * objectness >= threshold)
      append(cell, class_with(classes, best), best * objectness, threshold, found);
  }
}

// best[i] = the greatest of `classes` planes at cell i of a block. NaN is less than every number.
void best_of_planes(const float* planes, size_t stride, size_t classes, size_t count,
                    float* best) noexcept {
  const auto greater = [](float a, float b) { return a > b ? a : b; };
  std::fill_n(best, count, -std::numeric_limits<float>::infinity());
  size_t c = 0;
  for (; c + 4 <= classes; c += 4) {  // four planes for each pass over `best`
    const float *p0 = planes + c * stride, *p1 = p0 + stride, *p2 = p1 + stride, *p3 = p2 + stride;
    for (size_t i = 0; i < count; ++i)
      best[i] = greater(p3[i], greater(p2[i], greater(p1[i], greater(p0[i], best[i]))));
  }
  for (; c < classes; ++c)
    for (size_t i = 0; i < count; ++i) best[i] = greater(planes[c * stride + i], best[i]);
}

bool any_reaches(const float* values, size_t count, float threshold) noexcept {
  uint32_t reached = 0;
  for (size_t i = 0; i < count; ++i) reached |= values[i] >= threshold;
  return reached != 0;
}

int32_t class_in_planes(const float* planes, size_t stride, size_t classes, float score) noexcept {
  for (size_t c = 0; c < classes; ++c)
    if (planes[c * stride] == score) return static_cast<int32_t>(c);
  return 0;
}

// Reads the block of `count` cells from `first`; `planes` are its class scores, `objectness` is
// null or its objectness.
void find_in_block(const float* planes, const float* objectness, const DenseScores& scores,
                   size_t first, size_t count, float threshold, std::vector<ScoredCell>* found) {
  if (objectness && !any_reaches(objectness, count, threshold)) return;
  std::array<float, kBlock> best, products;
  best_of_planes(planes, scores.cells, scores.classes, count, best.data());
  const float* reached = best.data();
  if (objectness) {
    for (size_t i = 0; i < count; ++i) products[i] = best[i] * objectness[i];
    reached = products.data();
  }
  if (!any_reaches(reached, count, threshold)) return;
  for (size_t i = 0; i < count; ++i)
    if (reached[i] >= threshold && (!objectness || objectness[i] >= threshold))
      append(first + i, class_in_planes(planes + i, scores.cells, scores.classes, best[i]),
             reached[i], threshold, found);
}

void find_in_planes(std::span<const float> numbers, const DenseScores& scores, float threshold,
                    std::vector<ScoredCell>* found) {
  for (size_t first = 0; first < scores.cells; first += kBlock) {
    const float* planes = numbers.data() + scores.first_class * scores.cells + first;
    const float* objectness = scores.has_objectness ? planes - scores.cells : nullptr;
    find_in_block(planes, objectness, scores, first, std::min(kBlock, scores.cells - first),
                  threshold, found);
  }
}

}  // namespace

void find_scored_cells(std::span<const float> numbers, const DenseScores& scores, float threshold,
                       std::vector<ScoredCell>* found) {
  if (scores.cells_are_inner)
    find_in_planes(numbers, scores, threshold, found);
  else
    find_in_rows(numbers, scores, threshold, found);
}

}  // namespace weir::detection
