// Computes the corners of rotated rectangles.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/decoders/rotated_outline.hpp"

#include <array>
#include <cmath>

namespace weir::decoders {

void draw_rotated(const detection::PixelBox& box, detection::PictureSize input, draw::Size output,
                  draw::RgbaFrame* frame) noexcept {
  struct Point {
    double x, y;
  };
  const double half_width = box.width / 2.0, half_height = box.height / 2.0;
  const double cosine = std::cos(double{box.angle}), sine = std::sin(double{box.angle});
  std::array<Point, 4> corners{{{-half_width, -half_height},
                                {half_width, -half_height},
                                {half_width, half_height},
                                {-half_width, half_height}}};
  for (Point& corner : corners)
    corner = {(box.x + corner.x * cosine - corner.y * sine) * output.width / input.width,
              (box.y + corner.x * sine + corner.y * cosine) * output.height / input.height};
  for (size_t i = 0; i < corners.size(); ++i) {
    const Point &from = corners[i], &to = corners[(i + 1) % corners.size()];
    frame->line(static_cast<int64_t>(from.x), static_cast<int64_t>(from.y),
                static_cast<int64_t>(to.x), static_cast<int64_t>(to.y), draw::kRed);
  }
}

}  // namespace weir::decoders
