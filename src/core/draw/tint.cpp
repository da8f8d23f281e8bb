// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/tint.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace weir::draw {
namespace {

constexpr int kOne = 256;                      // weights of rows sum to it
constexpr int kLimit = 127 * kOne + kOne / 2;  // above: inside

// The elements around the centre of pixel `i` of `pixels`, and the weight of the second one.
struct Between {
  uint32_t first = 0, second = 0;
  int weight = 0;  // of kOne
};
Between elements_at(int64_t pixel, int64_t pixels, uint32_t elements) {
  const double at =
      (static_cast<double>(pixel) + 0.5) * elements / static_cast<double>(pixels) - 0.5;
  const double clamped = std::clamp(at, 0.0, static_cast<double>(elements - 1));
  const auto first = static_cast<uint32_t>(clamped);
  return {first, std::min(first + 1, elements - 1),
          static_cast<int>(std::lround((clamped - first) * kOne))};
}

// The least integer that is not below `value`, which fits.
int64_t ceiling(double value) {
  const auto whole = static_cast<int64_t>(value);
  return whole + (static_cast<double>(whole) < value);
}

// The first pixel whose centre is at or after the place `element` + `part` of the mask's row, where
// 0 is the centre of the first element.
int64_t pixel_from(double element, int64_t pixels, uint32_t elements) {
  return ceiling((element + 0.5) * static_cast<double>(pixels) / elements - 0.5);
}

// Pixels between two rows of a mask.
struct MaskRow {
  const uint8_t *above, *below;
  int weight;  // of the row below, of kOne
  uint32_t width;

  // Above 0: inside.
  int value(uint32_t x) const { return above[x] * (kOne - weight) + below[x] * weight - kLimit; }
};

// Tints the runs of the pixels `at`, one row of the picture, that are inside. `edges`: those of
// MaskTinter. Between two centres the value is linear, so each change of sign is one end of a run.
void tint_row(const MaskRow& row, std::span<const uint32_t> edges, const Area& at, uint8_t opacity,
              const Paint& paint, Canvas* canvas) {
  int64_t begin = row.value(0) > 0 ? at.left : at.right;
  for (const uint32_t x : edges) {
    const int a = row.value(x), b = row.value(x + 1);
    if ((a > 0) == (b > 0)) continue;
    const double place = x + static_cast<double>(a) / (a - b);
    const int64_t pixel = at.left + pixel_from(place, at.right - at.left, row.width);
    if (b > 0)
      begin = pixel;
    else
      canvas->tint({begin, at.top, pixel, at.bottom}, opacity, paint);
  }
  if (row.value(row.width - 1) > 0)
    canvas->tint({begin, at.top, at.right, at.bottom}, opacity, paint);
}

}  // namespace

// Between four values that are all inside (128 or more), or all outside, every value is.
void MaskTinter::find_edges(const uint8_t* above, const uint8_t* below, uint32_t width) {
  inside_.resize(width);
  uint8_t* const inside = inside_.data();  // a member would be read again after each store
  for (size_t x = 0; x < width; ++x)
    inside[x] = static_cast<uint8_t>((above[x] >> 7) + (below[x] >> 7));
  edges_.clear();
  for (uint32_t x = 0; x + 1 < width; ++x) {
    uint64_t here, next;  // of 8 elements
    while (x + sizeof here < width && inside[x] != 1) {
      std::memcpy(&here, inside + x, sizeof here);
      std::memcpy(&next, inside + x + 1, sizeof next);
      if (here != next) break;
      x += sizeof here;
    }
    if (x + 1 < width && (inside[x] == 1 || inside[x] != inside[x + 1])) edges_.push_back(x);
  }
}

void MaskTinter::tint(const Area& area, const AreaMask& mask, uint8_t opacity, const Paint& paint,
                      Canvas* canvas) {
  const Area seen = common_part(area, canvas->all());
  if (seen.empty()) return;
  const int64_t height = area.bottom - area.top;
  uint32_t known = mask.height;  // the first row of those that edges_ is of
  for (int64_t y = seen.top; y < seen.bottom; ++y) {
    const Between rows = elements_at(y - area.top, height, mask.height);
    const uint8_t* const above = mask.values.data() + size_t{rows.first} * mask.width;
    const uint8_t* const below = mask.values.data() + size_t{rows.second} * mask.width;
    if (std::exchange(known, rows.first) != rows.first) find_edges(above, below, mask.width);
    tint_row({above, below, rows.weight, mask.width}, edges_, {area.left, y, area.right, y + 1},
             opacity, paint, canvas);
  }
}

void tint_classes(const Area& area, uint32_t width, uint32_t height,
                  std::span<const uint16_t> classes, uint8_t opacity,
                  const std::function<const Paint*(uint16_t)>& paint_of_class, Canvas* canvas) {
  const Area seen = common_part(area, canvas->all());
  if (seen.empty() || classes.empty()) return;
  const int64_t across = area.right - area.left, down = area.bottom - area.top;
  for (int64_t y = seen.top; y < seen.bottom; ++y) {
    const auto row = static_cast<size_t>((2 * (y - area.top) + 1) * height / (2 * down));
    const uint16_t* const of_row = classes.data() + row * width;
    for (uint32_t x = 0; x < width;) {
      uint32_t end = x + 1;
      while (end < width && of_row[end] == of_row[x]) ++end;
      if (const Paint* paint = paint_of_class(of_row[x])) {
        // Pixels whose nearest element is from x to end - 1.
        const int64_t left = (2 * int64_t{x} * across + width - 1) / (2 * int64_t{width});
        const int64_t right = (2 * int64_t{end} * across + width - 1) / (2 * int64_t{width});
        canvas->tint({area.left + left, y, area.left + right, y + 1}, opacity, *paint);
      }
      x = end;
    }
  }
}

}  // namespace weir::draw
