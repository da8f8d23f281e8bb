// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/centroid_tracker.hpp"

#include <algorithm>
#include <limits>

namespace weir::detection {
namespace {

constexpr size_t kMaxObjects = 100;
constexpr uint32_t kMaxMissing = 100;  // frames

}  // namespace

struct CentroidTracker::Pair {
  double distance = std::numeric_limits<double>::infinity();  // squared
  size_t box = 0;
  bool exists() const noexcept { return distance < std::numeric_limits<double>::infinity(); }
};

CentroidTracker::Pair CentroidTracker::nearest_box(const Object& object,
                                                   std::span<const PixelBox> boxes,
                                                   std::span<const uint64_t> numbers) const {
  Pair nearest;
  for (size_t i = 0; i < boxes.size(); ++i) {
    if (numbers[i] != 0) continue;
    const double dx = 2.0 * boxes[i].x + boxes[i].width - static_cast<double>(object.x);
    const double dy = 2.0 * boxes[i].y + boxes[i].height - static_cast<double>(object.y);
    const double distance = dx * dx + dy * dy;
    if (distance < nearest.distance) nearest = {distance, i};
  }
  return nearest;
}

// The object that is nearest to its box, of those without a match; nullopt: there is none.
std::optional<size_t> CentroidTracker::closest(const std::vector<Pair>& nearest,
                                               const std::vector<bool>& is_matched) {
  std::optional<size_t> best;
  for (size_t i = 0; i < nearest.size(); ++i)
    if (!is_matched[i] && nearest[i].exists() &&
        (!best || nearest[i].distance < nearest[*best].distance))
      best = i;
  return best;
}

void CentroidTracker::match(std::span<const PixelBox> boxes, std::vector<uint64_t>* numbers) {
  std::vector<Pair> nearest;
  for (const Object& object : objects_) nearest.push_back(nearest_box(object, boxes, *numbers));
  std::vector<bool> is_matched(objects_.size());
  while (const auto best = closest(nearest, is_matched)) {
    uint64_t& number = (*numbers)[nearest[*best].box];
    if (number != 0) {  // another object has it by now
      nearest[*best] = nearest_box(objects_[*best], boxes, *numbers);
      continue;
    }
    number = objects_[*best].number;
    is_matched[*best] = true;
    objects_[*best].missing = 0;
  }
  for (size_t i = 0; i < objects_.size(); ++i)
    if (!is_matched[i]) ++objects_[i].missing;
}

std::vector<uint64_t> CentroidTracker::follow(std::span<const PixelBox> boxes) {
  std::vector<uint64_t> numbers(boxes.size());
  match(boxes, &numbers);
  std::erase_if(objects_, [](const Object& object) { return object.missing >= kMaxMissing; });
  for (size_t i = 0; i < boxes.size() && objects_.size() < kMaxObjects; ++i) {
    if (numbers[i] != 0) continue;
    numbers[i] = ++last_;
    objects_.push_back({.number = last_,
                        .x = 2 * int64_t{boxes[i].x} + boxes[i].width,
                        .y = 2 * int64_t{boxes[i].y} + boxes[i].height});
  }
  return numbers;
}

void CentroidTracker::reset() noexcept {
  objects_.clear();
  last_ = 0;
}

}  // namespace weir::detection
