// Helpers for detectors: boxes, overlap, non-maximum suppression, and the tensor layout in which
// detections travel between elements.
//
//   const auto kept = weir::suppress(boxes, scores, 0.5f, weir::Overlap::OfUnion);
//   for (const uint32_t i : kept) use(boxes[i]);
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

namespace weir {

// Edges in pixels from the picture's top left corner: the first pixel spans 0 to 1, so a box around
// the pixels 3 to 5 has x1 = 3 and x2 = 6.
struct Box {
  float x1 = 0, y1 = 0, x2 = 0, y2 = 0;

  float width() const noexcept { return x2 - x1; }
  float height() const noexcept { return y2 - y1; }
  // Returns 0 for a box with negative sides or NaN edges.
  float area() const noexcept { return width() > 0 && height() > 0 ? width() * height() : 0; }
  bool operator==(const Box&) const = default;
};

// Returns the intersection; its area() is 0 if the boxes do not meet.
inline Box common_part(const Box& a, const Box& b) noexcept {
  return {std::max(a.x1, b.x1), std::max(a.y1, b.y1), std::min(a.x2, b.x2), std::min(a.y2, b.y2)};
}

// The denominator of overlap().
enum class Overlap {
  OfUnion,   // intersection over union: 1 for equal boxes
  OfSmaller  // 1 if one box contains the other
};

// Returns 0 to 1; 0 if either box has no area.
inline float overlap(const Box& a, const Box& b, Overlap share = Overlap::OfUnion) noexcept {
  const float common = common_part(a, b).area(), smaller = std::min(a.area(), b.area());
  if (!(common > 0 && smaller > 0)) return 0;
  return common / (share == Overlap::OfUnion ? a.area() + b.area() - common : smaller);
}

// Selects boxes by greedy non-maximum suppression and returns their indices, best first. A box is
// removed when a kept box of equal or higher score overlaps it by more than `threshold`; ties go to
// the earlier box. With `classes`, boxes only suppress boxes of the same class. Boxes with a NaN
// score are removed. Precondition: as many scores (and classes, unless empty) as boxes.
inline std::vector<uint32_t> suppress(std::span<const Box> boxes, std::span<const float> scores,
                                      float threshold, Overlap share = Overlap::OfUnion,
                                      std::span<const float> classes = {}) {
  std::vector<uint32_t> order(boxes.size());
  std::iota(order.begin(), order.end(), 0u);
  std::erase_if(order, [&](uint32_t i) { return !(scores[i] == scores[i]); });
  std::stable_sort(order.begin(), order.end(),
                   [&](uint32_t a, uint32_t b) { return scores[a] > scores[b]; });
  std::vector<uint32_t> kept;
  for (const uint32_t i : order) {
    const bool doubled = std::any_of(kept.begin(), kept.end(), [&](uint32_t k) {
      return (classes.empty() || classes[k] == classes[i]) &&
             overlap(boxes[k], boxes[i], share) > threshold;
    });
    if (!doubled) kept.push_back(i);
  }
  return kept;
}

// Returns the square with the same centre and the length of the longer side.
inline Box square_around(const Box& box) noexcept {
  const float half = std::max(box.width(), box.height()) / 2;
  const float x = (box.x1 + box.x2) / 2, y = (box.y1 + box.y2) / 2;
  return {x - half, y - half, x + half, y + half};
}

// Moves the edges by fractions of the sides, as in bounding-box regression: x1 + dx1 * width, y1 +
// dy1 * height, x2 + dx2 * width, y2 + dy2 * height.
inline Box moved(const Box& box, float dx1, float dy1, float dx2, float dy2) noexcept {
  const float w = box.width(), h = box.height();
  return {box.x1 + dx1 * w, box.y1 + dy1 * h, box.x2 + dx2 * w, box.y2 + dy2 * h};
}

// One row of the tensor that tensor_overlay takes: float32, one row per detection,
//   x1, y1, x2, y2, score, class, then x and y of each key point,
// in pixels of the picture. A row with a score of 0 is background: a frame without detections has
// one row of zeros.
template <class Number>
class DetectionRow {
 public:
  static constexpr size_t kFixed = 6;
  static constexpr size_t length(size_t key_points) noexcept { return kFixed + 2 * key_points; }

  // `row` has length(key_points) numbers and is borrowed.
  explicit DetectionRow(std::span<Number> row) noexcept : row_(row) {}
  Box box() const noexcept { return {row_[0], row_[1], row_[2], row_[3]}; }
  Number& score() const noexcept { return row_[4]; }
  Number& class_index() const noexcept { return row_[5]; }
  size_t key_points() const noexcept { return (row_.size() - kFixed) / 2; }
  Number& x(size_t key_point) const noexcept { return row_[kFixed + 2 * key_point]; }
  Number& y(size_t key_point) const noexcept { return row_[kFixed + 2 * key_point + 1]; }
  void set_box(const Box& box) const noexcept {
    row_[0] = box.x1, row_[1] = box.y1, row_[2] = box.x2, row_[3] = box.y2;
  }

 private:
  std::span<Number> row_;
};

}  // namespace weir
