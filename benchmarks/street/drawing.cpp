// Boxes, areas and counts with OpenCV's drawing functions.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "drawing.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

namespace street {
namespace {

constexpr int kLineWidth = 3;
constexpr double kTextScale = 0.9;

void write(const std::string& text, cv::Point at, const cv::Scalar& color, cv::Mat* picture) {
  cv::putText(*picture, text, at, cv::FONT_HERSHEY_SIMPLEX, kTextScale, color, 2);
}

cv::Point pixel(double x, double y) {
  return {static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y))};
}

}  // namespace

void draw_people(std::span<const Detection> people, cv::Mat* picture) {
  const cv::Scalar green(0, 255, 0);
  for (const Detection& person : people) {
    const weir::Box& box = person.box;
    cv::rectangle(*picture, pixel(box.x1, box.y1), pixel(box.x2, box.y2), green, kLineWidth);
    const std::string number = person.track > 0 ? "#" + std::to_string(person.track) + " " : "";
    write("person " + number + std::to_string(std::lround(100 * person.score)) + " %",
          pixel(box.x1, box.y1 - 8), green, picture);
  }
}

void draw_zones(const weir::zone::ZoneCounter& counter, cv::Mat* picture) {
  const auto& zones = counter.zones()->zones;
  const cv::Scalar white = cv::Scalar::all(255);
  for (size_t i = 0; i < zones.size(); ++i) {
    std::vector<cv::Point> points;
    for (const auto& point : zones[i].points) points.push_back(pixel(point.x, point.y));
    const bool is_line = zones[i].kind == weir::zone::Kind::Line;
    cv::polylines(*picture, points, !is_line, white, kLineWidth);
    const auto& total = counter.counts()[i].total;
    write(zones[i].name + " " +
              (is_line ? std::to_string(total.forward) + " " + std::to_string(total.backward)
                       : std::to_string(total.inside())),
          points[0] + cv::Point(8, 32), white, picture);
  }
}

}  // namespace street
