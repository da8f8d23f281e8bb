// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/crop/regions.hpp"
#include "core/tensor/geometry.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace weir {
namespace {

uint32_t dim(const Shape& shape, size_t i) {
  return std::max<uint32_t>(shape[i], 1);
}

// Clips the interval [begin, begin + length) to 0..size.
void clip(double begin, double length, uint32_t size, uint32_t* from, uint32_t* count) {
  const double first = std::trunc(begin), end = first + std::trunc(length);
  if (!std::isfinite(end)) return;
  const double low = std::clamp<double>(first, 0, size), high = std::clamp<double>(end, 0, size);
  *from = static_cast<uint32_t>(low);
  *count = high > low ? static_cast<uint32_t>(high) - *from : 0;
}

// Adds a region unless it is empty; `row` is that of a result, plus 1, or 0.
void add(const Rect& region, uint64_t row, Regions* out) {
  if (region.width == 0 || region.height == 0) {
    ++out->empty;
  } else if (out->inside.size() == kTensorLimit) {
    ++out->beyond_limit;
  } else {
    out->inside.push_back(region);
    if (row > 0) out->rows.push_back(row);
  }
}

template <class T>
double number(std::span<const std::byte> bytes, size_t index) {
  T value;
  std::memcpy(&value, bytes.data() + index * sizeof(T), sizeof(T));
  return static_cast<double>(value);
}

}  // namespace

Regions read_regions(const TensorSpec& spec, std::span<const std::byte> payload, uint32_t width,
                     uint32_t height) {
  Regions out;
  visit_type(spec.type, [&](auto type) {
    using T = typename decltype(type)::type;
    for (size_t i = 0; i + 4 <= payload.size() / sizeof(T); i += 4) {
      Rect region;
      clip(number<T>(payload, i), number<T>(payload, i + 2), width, &region.x, &region.width);
      clip(number<T>(payload, i + 1), number<T>(payload, i + 3), height, &region.y, &region.height);
      add(region, 0, &out);
    }
  });
  return out;
}

Regions read_regions(std::span<const preprocess::PictureBox> boxes, const SourceMap& map,
                     uint32_t width, uint32_t height) {
  Regions out;
  for (const preprocess::PictureBox& box : boxes) {
    const auto [left, top, right, bottom, rotation, row] = preprocess::make_upright(box);
    if (!(right > left && bottom > top)) {
      ++out.empty;
      continue;
    }
    double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
    for (const Point corner : {Point{left, top}, {right, top}, {left, bottom}, {right, bottom}}) {
      const Point at = map.to_tensor(corner);
      const bool is_turned = map.x_dimension == 2;
      const double along[2] = {is_turned ? at.y : at.x, is_turned ? at.x : at.y};
      for (const size_t d : {0, 1}) {
        low[d] = std::min(low[d], std::round(along[d]));
        high[d] = std::max(high[d], std::round(along[d]));
      }
    }
    Rect region;
    clip(low[0], high[0] - low[0], width, &region.x, &region.width);
    clip(low[1], high[1] - low[1], height, &region.y, &region.height);
    add(region, row, &out);
  }
  return out;
}

Status check_picture_dimensions(const SourceMap& map) {
  if (map.x_dimension + map.y_dimension == 3 && map.x_dimension * map.y_dimension == 2) return ok();
  return Error{.code = Code::SPEC_MISMATCH,
               .what = "the boxes of results lie in dimensions that are not cut",
               .offered = "a picture whose x is dimension " + std::to_string(map.x_dimension) +
                          " and whose y is dimension " + std::to_string(map.y_dimension),
               .needed = "channels:width:height",
               .difference = "order of the dimensions",
               .fix = "tensor_transform mode=transpose option=2:0:1:3"};
}

TensorSpec make_part_spec(const TensorSpec& whole, const Rect& region) {
  return {whole.type, Shape{dim(whole.shape, 0), region.width, region.height, 1}, ""};
}

StridedLayout make_layout(const TensorSpec& whole, const Rect& region) {
  const auto element = static_cast<int64_t>(element_size(whole.type));
  const int64_t pixel = element * dim(whole.shape, 0), line = pixel * dim(whole.shape, 1);
  return {static_cast<uint64_t>(region.y * line + region.x * pixel),
          {element, pixel, line, region.height * line}};
}

void cut(const TensorSpec& whole, std::span<const std::byte> in, const Rect& region,
         std::span<std::byte> out) {
  const size_t pixel = element_size(whole.type) * dim(whole.shape, 0);
  const size_t line = pixel * dim(whole.shape, 1), part = pixel * region.width;
  const std::byte* from = in.data() + region.y * line + region.x * pixel;
  for (size_t y = 0; y < region.height; ++y)
    std::memcpy(out.data() + y * part, from + y * line, part);
}

}  // namespace weir
