// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/canvas.hpp"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "core/draw/tint_row.hpp"

namespace weir::draw {
namespace {

template <size_t Step>
void fill_row(std::byte* row, int64_t count, const uint8_t* pixel) {
  for (int64_t i = 0; i < count; ++i) std::memcpy(row + i * int64_t{Step}, pixel, Step);
}
template <>
void fill_row<1>(std::byte* row, int64_t count, const uint8_t* pixel) {
  std::memset(row, *pixel, static_cast<size_t>(count));
}
using FillRow = void (*)(std::byte*, int64_t, const uint8_t*);
constexpr FillRow kFillRow[] = {fill_row<1>, fill_row<2>, fill_row<3>, fill_row<4>};

void blend_row(std::byte* row, const uint8_t* coverage, size_t bytes, const Pattern& pattern) {
  auto* d = reinterpret_cast<uint8_t*>(row);
  size_t at = 0;
  for (; at + kPatternPeriod <= bytes; at += kPatternPeriod)
    for (size_t i = 0; i < kPatternPeriod; ++i)
      d[at + i] = mixed(d[at + i], pattern[i], coverage[at + i]);
  for (size_t i = 0; at + i < bytes; ++i)
    d[at + i] = mixed(d[at + i], pattern[i], coverage[at + i]);
}

int64_t samples(int64_t pixels, bool halved) {
  return halved ? (pixels + 1) / 2 : pixels;
}

// Whether every row is within the plane's memory.
bool holds(const Plane& plane, int64_t rows, int64_t row_bytes) {
  constexpr int64_t kMax = int64_t{1} << 40;
  if (plane.offset > static_cast<size_t>(kMax) || plane.stride > kMax || plane.stride < -kMax)
    return false;
  const auto first = static_cast<int64_t>(plane.offset);
  const auto [low, high] = std::minmax({first, first + (rows - 1) * int64_t{plane.stride}});
  return low >= 0 && high + row_bytes <= static_cast<int64_t>(plane.memory.size());
}

}  // namespace

Area common_part(const Area& a, const Area& b) noexcept {
  return {std::max(a.left, b.left), std::max(a.top, b.top), std::min(a.right, b.right),
          std::min(a.bottom, b.bottom)};
}

Canvas::Canvas(const preprocess::Picture& picture, const Planes& planes)
    : picture_(picture), planes_(planes) {
  std::array<bool, 3> seen{};
  for (size_t i = 0; i < picture.format.component_count(); ++i) {
    const preprocess::Component& component = picture.format.components[i];
    preprocess::Component& coarsest = components_[component.plane];
    const bool is_first = !std::exchange(seen[component.plane], true);
    mixed_[component.plane] =
        mixed_[component.plane] || (!is_first && !coarsest.same_grid(component));
    if (is_first || component.step > coarsest.step) coarsest = component;
    halved_ = halved_ || component.halved_columns || component.halved_rows;
  }
}

Result<Canvas> Canvas::make(const preprocess::Picture& picture, const Planes& planes) {
  const Canvas out(picture, planes);
  for (size_t i = 0; i < picture.format.plane_count(); ++i) {
    const preprocess::Component& component = out.components_[i];
    const int64_t row_bytes = samples(picture.width, component.halved_columns) * component.step;
    if (!holds(planes[i], samples(picture.height, component.halved_rows), row_bytes))
      return Error{.code = Code::FRAME_SIZE,
                   .what = "a picture is shorter than its size requires",
                   .offered = "plane " + std::to_string(i) + " of " +
                              std::to_string(planes[i].memory.size()) + " bytes, offset " +
                              std::to_string(planes[i].offset) + ", stride " +
                              std::to_string(planes[i].stride),
                   .needed = std::string(picture.format.name) + " " +
                             std::to_string(picture.width) + "x" + std::to_string(picture.height),
                   .fix = "check the upstream element"};
  }
  return out;
}

Area Canvas::all() const noexcept {
  return {0, 0, picture_.width, picture_.height};
}

std::byte* Canvas::at(size_t plane, int64_t x, int64_t y) const noexcept {
  const Plane& p = planes_[plane];
  return p.memory.data() + static_cast<ptrdiff_t>(p.offset) + y * p.stride +
         x * components_[plane].step;
}

void Canvas::fill(const Area& area, const Paint& paint) noexcept {
  const Area part = common_part(area, all());
  if (part.empty()) return;
  for (size_t plane = 0; plane < picture_.format.plane_count(); ++plane)
    if (!mixed_[plane]) fill_plane(plane, part, paint);
  for (size_t i = 0; i < picture_.format.component_count(); ++i) {
    const preprocess::Component& component = picture_.format.components[i];
    if (mixed_[component.plane])
      fill_component(component, part, paint.planes[component.plane][component.offset]);
  }
}

void Canvas::fill_plane(size_t plane, const Area& part, const Paint& paint) noexcept {
  const preprocess::Component& component = components_[plane];
  const int64_t left = component.halved_columns ? part.left / 2 : part.left;
  const int64_t top = component.halved_rows ? part.top / 2 : part.top;
  const int64_t count = samples(part.right, component.halved_columns) - left;
  const FillRow fill_one = kFillRow[component.step - 1];
  for (int64_t y = top; y < samples(part.bottom, component.halved_rows); ++y)
    fill_one(at(plane, left, y), count, paint.planes[plane].data());
}

void Canvas::fill_component(const preprocess::Component& component, const Area& part,
                            uint8_t sample) noexcept {
  const int64_t left = component.halved_columns ? part.left / 2 : part.left;
  const int64_t right = samples(part.right, component.halved_columns);
  for (int64_t y = part.top; y < part.bottom; ++y) {
    std::byte* const row = at(component.plane, 0, y) + component.offset;
    for (int64_t x = left; x < right; ++x) row[x * component.step] = std::byte{sample};
  }
}

void Canvas::tint(const Area& area, uint8_t opacity, const Paint& paint) noexcept {
  const Area part = common_part(area, all());
  if (part.empty()) return;
  for (size_t plane = 0; plane < picture_.format.plane_count(); ++plane) {
    const preprocess::Component& component = components_[plane];
    const int64_t left = component.halved_columns ? (part.left + 1) / 2 : part.left;
    const int64_t right = component.halved_columns ? (part.right + 1) / 2 : part.right;
    const int64_t top = component.halved_rows ? (part.top + 1) / 2 : part.top;
    const int64_t bottom = component.halved_rows ? (part.bottom + 1) / 2 : part.bottom;
    if (left >= right) continue;
    const auto bytes = static_cast<size_t>((right - left) * component.step);
    for (int64_t y = top; y < bottom; ++y)
      tint_row(at(plane, left, y), opacity, bytes, paint.planes[plane]);
  }
}

void Canvas::blend(int64_t x, int64_t y, const PlaneMask& mask, const Paint& paint) noexcept {
  const Area part = common_part({x, y, x + mask.width, y + mask.height}, all());
  if (part.empty()) return;
  for (size_t plane = 0; plane < picture_.format.plane_count(); ++plane) {
    const preprocess::Component& component = components_[plane];
    const int64_t left = component.halved_columns ? x / 2 : x,
                  top = component.halved_rows ? y / 2 : y;
    const auto bytes = static_cast<size_t>((samples(part.right, component.halved_columns) - left) *
                                           component.step);
    const uint8_t* coverage = mask.planes[plane].coverage.data();
    for (int64_t row = top; row < samples(part.bottom, component.halved_rows); ++row) {
      blend_row(at(plane, left, row), coverage, bytes, paint.planes[plane]);
      coverage += mask.planes[plane].row_bytes;
    }
  }
}

}  // namespace weir::draw
