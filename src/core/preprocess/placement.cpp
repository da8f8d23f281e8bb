// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/placement.hpp"

#include <algorithm>
#include <string>

namespace weir::preprocess {
namespace {

// a * b / c, rounded to the nearest integer and clamped to 1..limit.
uint32_t in_proportion(uint32_t a, uint32_t b, uint32_t c, uint32_t limit) noexcept {
  const uint64_t rounded = (uint64_t{2} * a * b + c) / (uint64_t{2} * c);
  return static_cast<uint32_t>(std::clamp<uint64_t>(rounded, 1, limit));
}

// The largest centred part of `whole` with the proportions of `shape`.
Rect middle(const Rect& whole, const Rect& shape) noexcept {
  Rect out = whole;
  const bool too_wide = uint64_t{whole.width} * shape.height > uint64_t{whole.height} * shape.width;
  if (too_wide)
    out.width = in_proportion(whole.height, shape.width, shape.height, whole.width);
  else
    out.height = in_proportion(whole.width, shape.height, shape.width, whole.height);
  out.x += (whole.width - out.width) / 2;
  out.y += (whole.height - out.height) / 2;
  return out;
}

// Division rounded up, for b > 0.
int64_t up(int64_t a, int64_t b) noexcept {
  return a > 0 ? (a + b - 1) / b : -(-a / b);
}

// The part of [begin, begin + length), mapped onto the targets [at, at + targets), whose target
// centres are within the picture's part [low, low + size).
struct Clipped {
  uint32_t begin, length, at, targets;
  AxisWhole whole;
};
Clipped clip(int64_t begin, uint32_t length, uint32_t at, uint32_t targets, uint32_t low,
             uint32_t size) noexcept {
  const int64_t high = int64_t{low} + size, twice = int64_t{2} * targets;
  // Region sides are at most 2^31 pixels, so anything farther away is invisible.
  constexpr int64_t kFar = int64_t{1} << 40;
  const int64_t near = std::clamp(begin, -kFar, kFar);
  const auto target = [&](int64_t pixel) {  // the first target whose centre is not before the pixel
    return std::clamp<int64_t>(up(twice * (pixel - near) - length, int64_t{2} * length), 0,
                               targets);
  };
  const int64_t first = target(low), end = target(high);
  const int64_t from = std::max<int64_t>(low, near), to = std::min<int64_t>(high, near + length);
  if (end <= first || to <= from) return {low, 0, at, 0, {}};
  return {static_cast<uint32_t>(from),
          static_cast<uint32_t>(to - from),
          at + static_cast<uint32_t>(first),
          static_cast<uint32_t>(end - first),
          {near, length, targets, static_cast<uint32_t>(first)}};
}

}  // namespace

Placement place(const Preparation& p, const Rect& picture, const Roi& region) noexcept {
  constexpr int64_t kMax = int64_t{1} << 31;
  Placement out{picture, Rect{0, 0, p.width, p.height}};
  if (region.width < 1 || region.height < 1 || region.width > kMax || region.height > kMax) {
    out.source.width = out.source.height = out.content.width = out.content.height = 0;
    return out;
  }
  Rect part{0, 0, static_cast<uint32_t>(region.width), static_cast<uint32_t>(region.height)};
  if (p.fit == Fit::Letterbox) out.content = middle(out.content, part);
  if (p.fit == Fit::CentreCrop) part = middle(part, out.content);
  const Rect content = out.content;
  if (region.rotation != 0) {
    out.rotated.emplace(region, part, content, picture);
    if (!out.rotated->shows_picture()) out.source = {}, out.content = {};
    return out;
  }
  const Clipped x =
      clip(region.x + part.x, part.width, content.x, content.width, picture.x, picture.width);
  const Clipped y =
      clip(region.y + part.y, part.height, content.y, content.height, picture.y, picture.height);
  const bool seen = x.targets > 0 && y.targets > 0;
  out.source = {x.begin, y.begin, seen ? x.length : 0, seen ? y.length : 0};
  out.content = {x.at, y.at, seen ? x.targets : 0, seen ? y.targets : 0};
  out.columns = x.whole;
  out.rows = y.whole;
  return out;
}

Placement place(const Preparation& p) noexcept {
  if (p.region)
    return place(p, p.crop.value_or(Rect{0, 0, p.source.width, p.source.height}), *p.region);
  Placement out{p.crop.value_or(Rect{0, 0, p.source.width, p.source.height}),
                Rect{0, 0, p.width, p.height}};
  if (p.fit == Fit::Letterbox) out.content = middle(out.content, out.source);
  if (p.fit == Fit::CentreCrop) out.source = middle(out.source, out.content);
  return out;
}

Status check_region(const Preparation& p, const Rect& picture, const Roi& region) {
  if (place(p, picture, region).content.width > 0) return ok();
  const auto text = [](const auto& part) {
    return std::to_string(part.width) + "x" + std::to_string(part.height) + " at " +
           std::to_string(part.x) + "," + std::to_string(part.y);
  };
  return Error{.code = Code::OPTION_VALUE,
               .what = "the region lies outside the picture",
               .offered = text(region),
               .needed = "a region with pixels in " + text(picture)};
}

SourceMap make_source_map(const Preparation& p) noexcept {
  const auto placed = place(p);
  const auto& [source, content, of_columns, of_rows, rotated] = placed;
  if (rotated) {
    SourceMap map = picture_as_it_is(p.source.width, p.source.height, p.layout == Layout::Nchw);
    map.width = p.width, map.height = p.height;
    rotated->set_transform(&map);
    return map;
  }
  const AxisWhole columns =
      of_columns.value_or(AxisWhole{source.x, source.width, content.width, 0});
  const AxisWhole rows = of_rows.value_or(AxisWhole{source.y, source.height, content.height, 0});
  const double scale_x = static_cast<double>(columns.length) / columns.targets;
  const double scale_y = static_cast<double>(rows.length) / rows.targets;
  const auto left = static_cast<double>(content.x) - columns.first;
  const auto top = static_cast<double>(content.y) - rows.first;
  return picture_as_it_is(p.source.width, p.source.height, p.layout == Layout::Nchw)
      .of_part(scale_x, static_cast<double>(columns.begin) - scale_x * left, scale_y,
               static_cast<double>(rows.begin) - scale_y * top, p.width, p.height);
}

}  // namespace weir::preprocess
