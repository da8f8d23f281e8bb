// Draws tracks, lines and counts on pictures as a program with OpenCV does.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <deque>
#include <map>
#include <opencv2/core.hpp>
#include <string>

#include "core/zone/zone_counter.hpp"

namespace street {

class Drawing {
 public:
  void draw_box(const weir::Box& box, uint32_t track, float score, cv::Mat* picture);
  void draw_zones(const weir::zone::ZoneCounter& counter, cv::Mat* picture) const;
  // Draws and shortens the trails; call it once for each picture, after the boxes.
  void draw_trails(cv::Mat* picture);

 private:
  struct Trail {
    std::deque<cv::Point> points;
    uint64_t picture = 0;  // in which it was last extended
  };
  std::map<uint32_t, Trail> trails_;
  uint64_t picture_ = 0;
};

}  // namespace street
