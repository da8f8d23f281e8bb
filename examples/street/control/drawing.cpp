// Boxes, trails, lines and counts with OpenCV's drawing functions.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "drawing.hpp"

#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace street {
namespace {

constexpr size_t kTrailPoints = 50;
constexpr int kLineWidth = 3;
constexpr double kTextScale = 0.9;

cv::Scalar color_of(uint32_t track) {
  return {60.0 + track * 67 % 196, 60.0 + track * 113 % 196, 60.0 + track * 151 % 196};
}

void write(const std::string& text, cv::Point at, const cv::Scalar& color, cv::Mat* picture) {
  cv::putText(*picture, text, at, cv::FONT_HERSHEY_SIMPLEX, kTextScale, color, 2);
}

cv::Point pixel(double x, double y) {
  return {static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y))};
}

}  // namespace

void Drawing::draw_box(const weir::Box& box, uint32_t track, float score, cv::Mat* picture) {
  const cv::Scalar color = color_of(track);
  cv::rectangle(*picture, pixel(box.x1, box.y1), pixel(box.x2, box.y2), color, kLineWidth);
  char text[64];
  std::snprintf(text, sizeof text, "person #%u %.0f%%", track, 100 * score);
  write(text, pixel(box.x1, box.y1 - 8), color, picture);
  if (track == 0) return;
  Trail& trail = trails_[track];
  trail.points.push_back(pixel((box.x1 + box.x2) / 2, (box.y1 + box.y2) / 2));
  if (trail.points.size() > kTrailPoints) trail.points.pop_front();
  trail.picture = picture_;
}

void Drawing::draw_zones(const weir::zone::ZoneCounter& counter, cv::Mat* picture) const {
  const auto& zones = counter.zones()->zones;
  for (size_t i = 0; i < zones.size(); ++i) {
    std::vector<cv::Point> points;
    for (const auto& point : zones[i].points) points.push_back(pixel(point.x, point.y));
    const cv::Scalar white = cv::Scalar::all(255);
    cv::polylines(*picture, points, points.size() > 2, white, kLineWidth);
    const auto& total = counter.counts()[i].total;
    write(zones[i].name + " " + std::to_string(total.forward) + " / " +
              std::to_string(total.backward),
          points[0] + cv::Point(8, -8), white, picture);
  }
}

void Drawing::draw_trails(cv::Mat* picture) {
  for (const auto& [track, trail] : trails_)
    cv::polylines(*picture, std::vector<cv::Point>(trail.points.begin(), trail.points.end()), false,
                  color_of(track), kLineWidth);
  std::erase_if(trails_,
                [&](const auto& one) { return picture_ - one.second.picture > kTrailPoints; });
  ++picture_;
}

}  // namespace street
