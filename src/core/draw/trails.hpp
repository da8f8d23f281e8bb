// Trails: where the tracks of the last frames of results were, for lines that follow them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <unordered_map>

#include "core/draw/detections.hpp"

namespace weir::draw {

inline constexpr uint32_t kTrailLimit = 1000;  // results of a trail, and trails

// One thread. Keeps at most kTrailLimit trails of `length` points.
class Trails {
 public:
  // How many frames of results a trail goes back; 0 = no trails.
  void set_length(uint32_t length);
  // The next frame of results. A track that is missing in `length` frames is forgotten.
  void add(const Detections& detections);
  void clear() noexcept { trails_.clear(); }

  // The positions of a track, the oldest first: middles of the lower edge of its boxes. Empty for a
  // track that is not known.
  const std::deque<Point>& of(const Detection& detection) const;
  size_t size() const noexcept { return trails_.size(); }

 private:
  struct Trail {
    uint64_t frame = 0;  // in which the track was seen last
    std::deque<Point> points{};
  };
  uint32_t length_ = 0;
  uint64_t frame_ = 0;
  std::unordered_map<uint64_t, Trail> trails_;  // by source and track
};

}  // namespace weir::draw
