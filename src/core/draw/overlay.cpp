// Converts coordinates to areas and draws them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/overlay.hpp"

#include <algorithm>
#include <cmath>

namespace weir::draw {
namespace {

// The nearest pixel boundary.
int64_t edge(double at) {
  constexpr double kFar = 1e9;  // pixels; larger coordinates make no difference
  return static_cast<int64_t>(std::floor(std::clamp(at, -kFar, kFar) + 0.5));
}

class Drawing {
 public:
  Drawing(const Detections& detections, const Style& style, Canvas* canvas)
      : detections_(detections), style_(style), canvas_(*canvas), all_(canvas->all()) {
    if (detections.picture_width > 0) x_scale_ = double(all_.right) / detections.picture_width;
    if (detections.picture_height > 0) y_scale_ = double(all_.bottom) / detections.picture_height;
    const int64_t size = style.point_size;
    for (int64_t y = 0; y < size; ++y) {
      int64_t x = 0;
      const auto away = [size](int64_t i) { return (2 * i + 1 - size) * (2 * i + 1 - size); };
      while (away(x) + away(y) > size * size) ++x;
      disc_.push_back(x);
    }
  }

  Area area_of(const Detection& d) const {
    const int64_t left = edge(d.x1 * x_scale_), top = edge(d.y1 * y_scale_);
    return {left, top, std::max(edge(d.x2 * x_scale_), left + 1),
            std::max(edge(d.y2 * y_scale_), top + 1)};
  }

  void box(const Area& a, const Paint& paint) {
    const int64_t line = style_.line_width;
    if (line == 0) return;
    if (a.right - a.left <= 2 * line || a.bottom - a.top <= 2 * line) {
      canvas_.fill(a, paint);
      return;
    }
    canvas_.fill({a.left, a.top, a.right, a.top + line}, paint);
    canvas_.fill({a.left, a.top + line, a.left + line, a.bottom - line}, paint);
    canvas_.fill({a.right - line, a.top + line, a.right, a.bottom - line}, paint);
    canvas_.fill({a.left, a.bottom - line, a.right, a.bottom}, paint);
  }

  void points(size_t row, const Paint& paint) {
    for (size_t i = 0; i < detections_.points_per_row; ++i) {
      const Point& point = detections_.points[row * detections_.points_per_row + i];
      if (std::isfinite(point.x) && std::isfinite(point.y))
        disc(point.x * x_scale_, point.y * y_scale_, paint);
    }
  }

  void label(const Detection& found, const Area& box, Labels* labels, Rgb color,
             const Paint& paint) {
    const PlaneMask* name = labels->name(found.class_index);
    const PlaneMask* score = detections_.scored ? labels->score(found.score) : nullptr;
    if (!name && !score) return;
    const int64_t height = name ? name->height : score->height;
    const int64_t gap = even(height / 4);
    int64_t width = gap;
    for (const PlaneMask* part : {name, score})
      if (part) width += even(part->width) + gap;
    const Area seen = common_part(box, all_);
    int64_t x = even_before(std::max<int64_t>(std::min(seen.left, all_.right - width), 0));
    const int64_t y = even_before(box.top >= height ? box.top - height : seen.top);
    canvas_.fill({x, y, x + width, y + height}, paint);
    const Paint ink = paint_of(canvas_.picture(), text_color(color));
    for (const PlaneMask* part : {name, score})
      if (part) {
        canvas_.blend(x + gap, y, *part, ink);
        x += gap + even(part->width);
      }
  }

 private:
  void disc(double x, double y, const Paint& paint) {
    const int64_t size = style_.point_size;
    const int64_t left = edge(x - static_cast<double>(size) / 2);
    const int64_t top = edge(y - static_cast<double>(size) / 2);
    for (int64_t row = 0; row < size; ++row) {
      const int64_t out = disc_[static_cast<size_t>(row)];
      canvas_.fill({left + out, top + row, left + size - out, top + row + 1}, paint);
    }
  }
  // Masks begin at even columns and rows if pixels share chroma.
  int64_t even(int64_t length) const { return canvas_.halved() ? (length + 1) / 2 * 2 : length; }
  int64_t even_before(int64_t place) const { return canvas_.halved() ? place / 2 * 2 : place; }

  const Detections& detections_;
  const Style& style_;
  Canvas& canvas_;
  const Area all_;
  double x_scale_ = 1, y_scale_ = 1;
  std::vector<int64_t> disc_;  // for each row, the pixels at both ends outside the disc
};

}  // namespace

Drawn draw(const Detections& detections, const Style& style, Labels* labels, Canvas* canvas) {
  Drawn out;
  Drawing drawing(detections, style, canvas);
  const auto paint = [&](const Detection& found) {
    return paint_of(canvas->picture(), class_color(found.class_index));
  };
  std::vector<size_t> seen;
  for (size_t i = 0; i < detections.rows.size(); ++i) {
    const Detection& found = detections.rows[i];
    const Area area = drawing.area_of(found);
    if (found.score < style.min_score) {
      ++out.below_score;
    } else if (common_part(area, canvas->all()).empty()) {
      ++out.outside;
    } else {
      seen.push_back(i);
      drawing.box(area, paint(found));
      drawing.points(i, paint(found));
    }
  }
  out.boxes = seen.size();
  if (!labels) return out;
  for (const size_t i : seen) {
    const Detection& found = detections.rows[i];
    drawing.label(found, drawing.area_of(found), labels, class_color(found.class_index),
                  paint(found));
  }
  return out;
}

}  // namespace weir::draw
