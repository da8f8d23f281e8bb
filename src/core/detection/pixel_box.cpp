// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/pixel_box.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/detection/box_grid.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::detection {
namespace {

int32_t truncated(float value) noexcept {
  constexpr float kFar = 0x1p30f;  // a sum of two of them fits into 32 bits
  return static_cast<int32_t>(std::clamp(value, -kFar, kFar - 64));
}

double get_area(const PixelBox& box) {
  return double(box.width) * box.height;
}

// A box with its axes, for points in and out of it.
struct Rotated {
  explicit Rotated(const PixelBox& box)
      : x(box.x),
        y(box.y),
        width(box.width),
        height(box.height),
        cosine(std::cos(double(box.angle))),
        sine(std::sin(double(box.angle))) {}
  bool contains(double at_x, double at_y) const {
    const double dx = at_x - x, dy = at_y - y;
    return std::abs(dx * cosine + dy * sine) <= width / 2 &&
           std::abs(dy * cosine - dx * sine) <= height / 2;
  }
  double reach() const { return std::hypot(width, height) / 2; }

  double x, y, width, height, cosine, sine;
};

Extent to_extent(const PixelBox& box) {
  const int64_t right = int64_t{box.x} + box.width, bottom = int64_t{box.y} + box.height;
  return {std::min<int64_t>(box.x, right), std::min<int64_t>(box.y, bottom),
          std::max<int64_t>(box.x, right), std::max<int64_t>(box.y, bottom)};
}

Extent extent_of_rotated(const PixelBox& box) {
  const auto reach = static_cast<int64_t>(std::hypot(box.width, box.height) / 2) + 1;
  return {box.x - reach, box.y - reach, box.x + reach, box.y + reach};
}

using OverlapOf = float (*)(const PixelBox&, const PixelBox&) noexcept;
using ExtentOf = Extent (*)(const PixelBox&);

// Boxes whose extents do not touch do not overlap. Every overlap is above a negative threshold.
template <OverlapOf overlap, ExtentOf extent>
PixelBoxes suppress_by(PixelBoxes boxes, float threshold) {
  constexpr size_t kFewBoxes = 512;  // for which a loop over all is faster than a grid
  std::stable_sort(boxes.begin(), boxes.end(), [](const PixelBox& a, const PixelBox& b) {
    return a.probability > b.probability;
  });
  std::vector<Extent> extents;
  std::unique_ptr<BoxGrid> grid;
  if (boxes.size() > kFewBoxes && threshold >= 0) {
    for (const PixelBox& box : boxes) extents.push_back(extent(box));
    grid = std::make_unique<BoxGrid>(extents);
  }
  size_t kept = 0;  // the boxes before it are kept
  for (size_t i = 0; i < boxes.size(); ++i) {
    const PixelBox box = boxes[i];
    const auto is_double = [&](const PixelBox& better) { return overlap(better, box) > threshold; };
    const auto end = boxes.begin() + static_cast<ptrdiff_t>(kept);
    const bool is_removed =
        grid ? grid->any_near(extents[i], [&](uint32_t k) { return is_double(boxes[k]); })
             : std::any_of(boxes.begin(), end, is_double);
    if (is_removed) continue;
    if (grid) grid->add(static_cast<uint32_t>(kept), extents[i]);
    boxes[kept++] = box;
  }
  boxes.resize(kept);
  return boxes;
}

}  // namespace

PixelBox to_pixels(const Candidate& candidate, Limits limits, Size picture) noexcept {
  PixelBox box{truncated(candidate.x),
               truncated(candidate.y),
               truncated(candidate.width),
               truncated(candidate.height),
               candidate.class_index,
               candidate.score,
               candidate.angle};
  if (limits == Limits::None) return box;
  box.x = std::max(box.x, 0);
  box.y = std::max(box.y, 0);
  if (limits == Limits::Corner) return box;
  box.width = std::min(box.width, static_cast<int32_t>(picture.width));
  box.height = std::min(box.height, static_cast<int32_t>(picture.height));
  return box;
}

PixelBoxes to_pixels(std::span<const Candidate> candidates, Limits limits, Size picture) {
  PixelBoxes boxes;
  boxes.reserve(candidates.size());
  for (const Candidate& candidate : candidates)
    boxes.push_back(to_pixels(candidate, limits, picture));
  return boxes;
}

float inclusive_overlap(const PixelBox& a, const PixelBox& b) noexcept {
  const int64_t width = int64_t{std::min(a.x + a.width, b.x + b.width)} - std::max(a.x, b.x) + 1;
  if (width <= 0) return 0;
  const int64_t height = int64_t{std::min(a.y + a.height, b.y + b.height)} - std::max(a.y, b.y) + 1;
  if (height <= 0) return 0;
  const int64_t common = width * height;
  const int64_t together = int64_t{a.width} * a.height + int64_t{b.width} * b.height - common;
  const float overlap = static_cast<float>(common) / static_cast<float>(together);
  return overlap < 0 ? 0 : overlap;
}

float rotated_overlap(const PixelBox& a, const PixelBox& b) noexcept {
  constexpr int kSteps = 6;
  const bool a_is_smaller = get_area(a) <= get_area(b);
  const Rotated smaller(a_is_smaller ? a : b), larger(a_is_smaller ? b : a);
  if (std::hypot(smaller.x - larger.x, smaller.y - larger.y) > smaller.reach() + larger.reach())
    return 0;
  int inside = 0;
  for (int row = 0; row < kSteps; ++row)
    for (int column = 0; column < kSteps; ++column) {
      const double along = ((column + 0.5) / kSteps - 0.5) * smaller.width;
      const double down = ((row + 0.5) / kSteps - 0.5) * smaller.height;
      inside += larger.contains(smaller.x + along * smaller.cosine - down * smaller.sine,
                                smaller.y + along * smaller.sine + down * smaller.cosine);
    }
  const double common = smaller.width * smaller.height * inside / (kSteps * kSteps);
  const double together = get_area(a) + get_area(b) - common;
  return together > 0 ? static_cast<float>(common / together) : 0;
}

PixelBoxes suppress(PixelBoxes boxes, float threshold) {
  return suppress_by<inclusive_overlap, to_extent>(std::move(boxes), threshold);
}

PixelBoxes suppress_rotated(PixelBoxes boxes, float threshold) {
  return suppress_by<rotated_overlap, extent_of_rotated>(std::move(boxes), threshold);
}

}  // namespace weir::detection
