// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/overlay.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>

#include "core/draw/label_layout.hpp"
#include "core/draw/lines.hpp"
#include "core/draw/skeleton.hpp"
#include "core/draw/tint.hpp"
#include "core/draw/zone_marks.hpp"

namespace weir::draw {
namespace {

constexpr uint8_t kOpaque = 255;
constexpr float kMinPointScore = 0.3f;  // of key points that are drawn

// The nearest pixel boundary.
int64_t edge(double at) {
  constexpr double kFar = 1e9;  // pixels; larger coordinates make no difference
  return static_cast<int64_t>(std::floor(std::clamp(at, -kFar, kFar) + 0.5));
}

class Drawing {
 public:
  Drawing(const Detections& detections, const Style& style, Canvas* canvas)
      : detections_(detections),
        style_(style),
        canvas_(*canvas),
        all_(canvas->all()),
        layout_(all_) {
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

  template <class Box>
  Area upright(const Box& b) const {
    const int64_t left = edge(b.x1 * x_scale_), top = edge(b.y1 * y_scale_);
    return {left, top, std::max(edge(b.x2 * x_scale_), left + 1),
            std::max(edge(b.y2 * y_scale_), top + 1)};
  }

  // The upright area around the box.
  Area get_area(const Detection& d) const {
    if (d.rotation == 0) return upright(d);
    Detection around;
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    around.x1 = around.y1 = kInfinity, around.x2 = around.y2 = -kInfinity;
    for (const Point& corner : get_corners(d)) {
      around.x1 = std::min(around.x1, corner.x), around.x2 = std::max(around.x2, corner.x);
      around.y1 = std::min(around.y1, corner.y), around.y2 = std::max(around.y2, corner.y);
    }
    return upright(around);
  }

  void class_maps() {
    if (style_.mask_opacity == 0) return;
    for (const ClassMap& map : detections_.class_maps) class_map(map);
  }
  void class_map(const ClassMap& map) {
    const auto paint = [&](uint16_t c) -> const Paint* {
      if (map.is_depth) return &paint_in(&paints_of_depths_, c, depth_color);
      return c == 0 ? nullptr : &paint_of_class(c);
    };
    tint_classes(upright(map), map.width, map.height, map.classes,
                 map.is_depth ? kOpaque : style_.mask_opacity, paint, &canvas_);
  }

  using Paints = std::map<uint32_t, Paint>;
  template <class ColorOf>
  const Paint& paint_in(Paints* paints, uint32_t index, const ColorOf& get_color) {
    const auto known = paints->find(index);
    if (known != paints->end()) return known->second;
    return paints->emplace(index, make_paint(canvas_.picture(), get_color(index))).first->second;
  }
  // The colour of a track stays with it from frame to frame.
  Rgb get_color(const Detection& d) const {
    const bool is_of_track = style_.has_track_colors && d.track > 0;
    return class_color(is_of_track ? d.track : d.class_index);
  }
  const Paint& paint_of_row(const Detection& d) {
    const bool is_of_track = style_.has_track_colors && d.track > 0;
    return paint_of_class(is_of_track ? d.track : d.class_index);
  }
  // The same for all of the class in this picture.
  const Paint& paint_of_class(uint32_t index) { return paint_in(&paints_, index, class_color); }

  void mask(const Detection& d, const Area& area) {
    if (d.is_label || d.mask < 0 || style_.mask_opacity == 0) return;
    const DetectionMask& mask = detections_.masks[static_cast<size_t>(d.mask)];
    tinter_.tint(area, {mask.width, mask.height, mask.values}, style_.mask_opacity, paint_of_row(d),
                 &canvas_);
  }

  void box(const Detection& d, const Area& a, const Paint& paint) {
    const int64_t line = style_.line_width;
    if (line == 0) return;
    if (d.rotation != 0) {
      auto corners = get_corners(d);
      for (Point& corner : corners) corner = on_canvas(corner);
      return draw_outline(corners, static_cast<double>(line), paint, &canvas_);
    }
    if (a.right - a.left <= 2 * line || a.bottom - a.top <= 2 * line) {
      canvas_.fill(a, paint);
      return;
    }
    canvas_.fill({a.left, a.top, a.right, a.top + line}, paint);
    canvas_.fill({a.left, a.top + line, a.left + line, a.bottom - line}, paint);
    canvas_.fill({a.right - line, a.top + line, a.right, a.bottom - line}, paint);
    canvas_.fill({a.left, a.bottom - line, a.right, a.bottom}, paint);
  }

  void trail(const Detection& d, const Trails& trails) {
    if (d.is_label) return;
    const auto& points = trails.of(d);
    for (size_t i = 1; i < points.size(); ++i)
      draw_line(on_canvas(points[i - 1]), on_canvas(points[i]), style_.line_width,
                paint_of_class(d.track), &canvas_);
  }

  void zones() {
    const auto& all = shown_zones();
    for (size_t i = 0; i < all.size(); ++i) zone(all[i], i);
  }
  void zone_labels(Labels* labels) {
    const auto& all = shown_zones();
    for (size_t i = 0; i < all.size(); ++i) zone_label(all[i], i, labels);
  }
  const std::vector<zone::Zone>& shown_zones() const {
    static const std::vector<zone::Zone> kNone;
    return detections_.has_zones() && style_.shows_zones ? detections_.zones->zones : kNone;
  }
  void zone(const zone::Zone& zone, size_t index) {
    std::vector<Point> points;
    for (const Point& p : zone.points) points.push_back(on_canvas(p));
    draw_zone(zone.kind, points, std::max<double>(style_.line_width, 1), paint_of_class(index),
              &canvas_);
  }
  void zone_label(const zone::Zone& zone, size_t index, Labels* labels) {
    const auto& totals = detections_.zone_totals;
    const std::string text =
        text_of_zone(zone, index < totals.size() ? totals[index] : ZoneTotal());
    const PlaneMask* const parts[] = {labels->text(text)};
    Detection box;
    box.x1 = box.x2 = zone.points[0].x, box.y1 = box.y2 = zone.points[0].y;
    for (const Point& p : zone.points) {
      box.x1 = std::min(box.x1, p.x), box.x2 = std::max(box.x2, p.x);
      box.y1 = std::min(box.y1, p.y), box.y2 = std::max(box.y2, p.y);
    }
    const Area area = upright(box);
    if (!common_part(area, all_).empty()) write(parts, area, false, class_color(index));
  }

  void points(size_t row, const Paint& paint) {
    const size_t count = detections_.points_per_row;
    for (const auto& [from, to] : get_connections(count))
      if (is_found(row, from) && is_found(row, to))
        draw_line(on_canvas(point(row, from)), on_canvas(point(row, to)), style_.line_width, paint,
                  &canvas_);
    for (size_t i = 0; i < count; ++i)
      if (is_found(row, i)) disc(on_canvas(point(row, i)), paint);
  }

  // Draws a label with a free place at `box`, or in the list of the picture.
  void label(const Detection& found, const Area& box, Labels* labels) {
    const PlaneMask* const parts[] = {
        found.text >= 0 ? labels->text(detections_.texts[static_cast<size_t>(found.text)])
                        : labels->name(found.source, found.class_index),
        found.track > 0 ? labels->text("#" + std::to_string(found.track)) : nullptr,
        detections_.scored ? labels->score(found.score) : nullptr};
    write(parts, box, found.is_label, get_color(found));
  }
  // The parts side by side on a ground of this colour.
  void write(std::span<const PlaneMask* const> parts, const Area& box, bool is_in_list, Rgb color) {
    const int64_t height = tallest(parts);
    if (height == 0) return;
    int64_t width = 0;
    const int64_t gap = even(height / 4);
    for (const PlaneMask* part : parts)
      if (part) width += even(part->width) + gap;
    const int64_t step = canvas_.halved() ? 2 : 1;
    const Area place = is_in_list ? layout_.place_in_list(box, width + gap, height, step)
                                  : layout_.place(box, width + gap, height, step);
    if (place.empty()) return;
    canvas_.fill(place, make_paint(canvas_.picture(), color));
    const Paint ink = make_paint(canvas_.picture(), text_color(color));
    int64_t x = place.left;
    for (const PlaneMask* part : parts)
      if (part) {
        canvas_.blend(x + gap, place.top, *part, ink);
        x += gap + even(part->width);
      }
  }

 private:
  static int64_t tallest(std::span<const PlaneMask* const> parts) {
    int64_t height = 0;
    for (const PlaneMask* part : parts)
      if (part) height = std::max<int64_t>(height, part->height);
    return height;
  }

  Point on_canvas(const Point& p) const { return {p.x * x_scale_, p.y * y_scale_}; }
  const Point& point(size_t row, size_t i) const {
    return detections_.points[row * detections_.points_per_row + i];
  }
  bool is_found(size_t row, size_t i) const {
    const Point& p = point(row, i);
    if (!std::isfinite(p.x) || !std::isfinite(p.y)) return false;
    return detections_.point_scores.empty() ||
           detections_.point_scores[row * detections_.points_per_row + i] >= kMinPointScore;
  }

  static std::array<Point, 4> get_corners(const Detection& d) {
    const double c = std::cos(double{d.rotation}), s = std::sin(double{d.rotation});
    const double x = (d.x1 + d.x2) / 2, y = (d.y1 + d.y2) / 2;
    const double w = (d.x2 - d.x1) / 2, h = (d.y2 - d.y1) / 2;
    std::array<Point, 4> out{{{-w, -h}, {w, -h}, {w, h}, {-w, h}}};
    for (Point& p : out) p = {x + p.x * c - p.y * s, y + p.x * s + p.y * c};
    return out;
  }

  void disc(const Point& centre, const Paint& paint) {
    const int64_t size = style_.point_size;
    const int64_t left = edge(centre.x - static_cast<double>(size) / 2);
    const int64_t top = edge(centre.y - static_cast<double>(size) / 2);
    for (int64_t row = 0; row < size; ++row) {
      const int64_t out = disc_[static_cast<size_t>(row)];
      canvas_.fill({left + out, top + row, left + size - out, top + row + 1}, paint);
    }
  }
  // Masks begin at even columns and rows if pixels share chroma.
  int64_t even(int64_t length) const { return canvas_.halved() ? (length + 1) / 2 * 2 : length; }

  const Detections& detections_;
  const Style& style_;
  Canvas& canvas_;
  const Area all_;
  LabelLayout layout_;
  MaskTinter tinter_;
  Paints paints_, paints_of_depths_;  // by class, by level
  double x_scale_ = 1, y_scale_ = 1;
  std::vector<int64_t> disc_;  // for each row, the pixels at both ends outside the disc
};

}  // namespace

uint32_t line_width_for(uint32_t height) noexcept {
  return std::max(1u, (height + 180) / 360);
}

uint32_t point_size_for(uint32_t height) noexcept {
  return std::max(3u, (height + 72) / 144);
}

uint32_t text_size_for(uint32_t height) noexcept {
  return std::clamp((height + 18) / 36, 10u, 200u);
}

Drawn draw(const Detections& detections, const Style& style, Labels* labels, Canvas* canvas,
           const Trails* trails) {
  Drawn out;
  Drawing drawing(detections, style, canvas);
  drawing.class_maps();
  drawing.zones();
  struct Seen {
    const Detection* found = nullptr;
    size_t row = 0;
    Area area;
  };
  std::vector<Seen> seen;
  for (size_t i = 0; i < detections.rows.size(); ++i) {
    const Detection& found = detections.rows[i];
    const Area area = drawing.get_area(found);
    if (found.score < style.min_score)
      ++out.below_score;
    else if (common_part(area, canvas->all()).empty())
      ++out.outside;
    else
      seen.push_back({&found, i, area});
  }
  for (const auto& one : seen) drawing.mask(*one.found, one.area);
  if (trails)
    for (const auto& one : seen) drawing.trail(*one.found, *trails);
  for (const auto& [found, row, area] : seen) {
    if (found->is_label) continue;
    drawing.box(*found, area, drawing.paint_of_row(*found));
    drawing.points(row, drawing.paint_of_row(*found));
    ++out.boxes;
  }
  if (!labels) return out;
  labels->begin_picture();
  std::stable_sort(seen.begin(), seen.end(),
                   [](const Seen& a, const Seen& b) { return a.found->score > b.found->score; });
  drawing.zone_labels(labels);
  for (const auto& one : seen) drawing.label(*one.found, one.area, labels);
  return out;
}

}  // namespace weir::draw
