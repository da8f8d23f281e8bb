// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/trails.hpp"

#include <algorithm>

namespace weir::draw {
namespace {

uint64_t make_key(const Detection& detection) noexcept {
  return uint64_t{detection.source} << 32 | detection.track;
}

}  // namespace

void Trails::set_length(uint32_t length) {
  length_ = std::min(length, kTrailLimit);
  for (auto& [key, trail] : trails_)
    while (trail.points.size() > length_) trail.points.pop_front();
}

void Trails::add(const Detections& detections) {
  ++frame_;
  std::erase_if(trails_, [this](const auto& entry) {
    return frame_ - entry.second.frame > std::max(length_, 1u);
  });
  if (length_ == 0) return trails_.clear();
  for (const Detection& found : detections.rows) {
    if (found.track == 0 || found.is_label) continue;
    const uint64_t key = make_key(found);
    if (trails_.size() == kTrailLimit && !trails_.contains(key)) continue;
    Trail& trail = trails_[key];
    if (trail.frame == frame_) continue;  // twice in a frame
    trail.frame = frame_;
    trail.points.push_back({(found.x1 + found.x2) / 2, found.y2});
    if (trail.points.size() > length_) trail.points.pop_front();
  }
}

const std::deque<Point>& Trails::of(const Detection& detection) const {
  static const std::deque<Point> kNone;
  const auto known = trails_.find(make_key(detection));
  return known == trails_.end() || detection.track == 0 ? kNone : known->second.points;
}

}  // namespace weir::draw
