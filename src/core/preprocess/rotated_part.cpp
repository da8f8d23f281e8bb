// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/rotated_part.hpp"

#include <algorithm>
#include <cmath>

namespace weir::preprocess {
namespace {

// Along one side of a plane.
struct Side {
  double low = 0, high = 0;  // the first and the last sample of the picture
  bool is_halved = false, is_cosited = false;

  // The position between samples, 0 at the centre of the first one in memory.
  double position(double pixel) const noexcept {
    if (!is_halved) return pixel - 0.5;
    return (pixel + (is_cosited ? 0.5 : 0)) / 2 - 0.5;
  }
  // The sample of the pixel, whose pair has it.
  double nearest(double pixel) const noexcept {
    const double whole = std::floor(pixel);
    return std::clamp(is_halved ? std::floor(whole / 2) : whole, low, high);
  }
};

Side make_side(uint32_t begin, uint32_t length, bool halved, bool cosited) noexcept {
  const auto [first, end] = samples_of(begin, length, halved);
  return {static_cast<double>(first), static_cast<double>(end) - 1, halved, cosited};
}

// Reads one component.
class Sampler {
 public:
  Sampler(const RotatedPart& part, const ComponentRows& in) noexcept
      : in_(in),
        x_(make_side(part.picture().x, part.picture().width, in.component.halved_columns,
                     in.is_cosited_in_columns)),
        y_(make_side(part.picture().y, part.picture().height, in.component.halved_rows,
                     in.is_cosited_in_rows)) {}

  double nearest(Point source) const noexcept {
    return at(x_.nearest(source.x), y_.nearest(source.y));
  }

  double bilinear(Point source) const noexcept {
    const double x = std::clamp(x_.position(source.x), x_.low, x_.high);
    const double y = std::clamp(y_.position(source.y), y_.low, y_.high);
    const double left = std::floor(x), top = std::floor(y);
    const double right = std::min(left + 1, x_.high), bottom = std::min(top + 1, y_.high);
    const double above = at(left, top) + (at(right, top) - at(left, top)) * (x - left);
    const double below = at(left, bottom) + (at(right, bottom) - at(left, bottom)) * (x - left);
    return above + (below - above) * (y - top);
  }

 private:
  double at(double x, double y) const noexcept {
    return in_.rows[static_cast<ptrdiff_t>(y) * in_.stride +
                    static_cast<ptrdiff_t>(x) * in_.component.step];
  }

  const ComponentRows& in_;
  Side x_, y_;
};

uint32_t points_along(double step) noexcept {
  constexpr double kMax = 16;
  return static_cast<uint32_t>(std::clamp(std::ceil(step), 1.0, kMax));
}

}  // namespace

std::pair<uint32_t, uint32_t> samples_of(uint32_t begin, uint32_t length, bool halved) noexcept {
  if (!halved) return {begin, begin + length};
  return {begin / 2, (begin + length + 1) / 2};
}

RotatedPart::RotatedPart(const Roi& region, const Rect& part, const Rect& content,
                         const Rect& picture) noexcept
    : step_x_(static_cast<double>(part.width) / content.width),
      step_y_(static_cast<double>(part.height) / content.height),
      content_(content),
      picture_(picture) {
  const double cosine = std::cos(region.rotation), sine = std::sin(region.rotation);
  xx_ = cosine * step_x_, xy_ = -sine * step_y_;
  yx_ = sine * step_x_, yy_ = cosine * step_y_;
  // The centre of the region, in the picture and in the tensor.
  const double half_width = static_cast<double>(region.width) / 2;
  const double half_height = static_cast<double>(region.height) / 2;
  const double x = content.x + (half_width - part.x) / step_x_;
  const double y = content.y + (half_height - part.y) / step_y_;
  x0_ = static_cast<double>(region.x) + half_width - xx_ * x - xy_ * y;
  y0_ = static_cast<double>(region.y) + half_height - yx_ * x - yy_ * y;
}

std::pair<uint32_t, uint32_t> RotatedPart::columns_inside(uint32_t row) const noexcept {
  const double right = static_cast<double>(picture_.x) + picture_.width;
  const double bottom = static_cast<double>(picture_.y) + picture_.height;
  const auto is_inside = [&](uint32_t column) {
    const Point at = to_source({column + 0.5, row + 0.5});
    return at.x >= picture_.x && at.x < right && at.y >= picture_.y && at.y < bottom;
  };
  const uint32_t end = content_.x + content_.width;
  uint32_t first = content_.x;
  while (first < end && !is_inside(first)) ++first;
  uint32_t last = end;
  while (last > first && !is_inside(last - 1)) --last;
  return {first, last};
}

bool RotatedPart::may_show_picture() const noexcept {
  const double left = content_.x, top = content_.y;
  const double right = left + content_.width, bottom = top + content_.height;
  double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
  for (const Point corner : {Point{left, top}, {right, top}, {left, bottom}, {right, bottom}}) {
    const Point at = to_source(corner);
    low[0] = std::min(low[0], at.x), high[0] = std::max(high[0], at.x);
    low[1] = std::min(low[1], at.y), high[1] = std::max(high[1], at.y);
  }
  const double end_x = static_cast<double>(picture_.x) + picture_.width;
  const double end_y = static_cast<double>(picture_.y) + picture_.height;
  return low[0] < end_x && high[0] > picture_.x && low[1] < end_y && high[1] > picture_.y;
}

bool RotatedPart::shows_picture() const noexcept {
  if (!may_show_picture()) return false;
  for (uint32_t row = content_.y; row < content_.y + content_.height; ++row)
    if (const auto [first, end] = columns_inside(row); first < end) return true;
  return false;
}

void sample_row(const RotatedPart& part, const ComponentRows& in, Resize resize, uint32_t row,
                std::pair<uint32_t, uint32_t> columns, float* out) noexcept {
  const Sampler sampler(part, in);
  const bool is_area = resize == Resize::Area;
  const uint32_t across = is_area ? points_along(part.step_x()) : 1;
  const uint32_t down = is_area ? points_along(part.step_y()) : 1;
  for (uint32_t column = columns.first; column < columns.second; ++column) {
    double sum = 0;
    for (uint32_t j = 0; j < down; ++j)
      for (uint32_t i = 0; i < across; ++i) {
        const Point source = part.to_source({column + (i + 0.5) / across, row + (j + 0.5) / down});
        sum += resize == Resize::Nearest ? sampler.nearest(source) : sampler.bilinear(source);
      }
    out[column - columns.first] = static_cast<float>(sum / (across * down));
  }
}

}  // namespace weir::preprocess
