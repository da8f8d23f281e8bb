// SourceMap: the transform from tensor to source picture coordinates.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>

#include "weir/abi.h"

namespace weir {

// In pixels from the top left corner. Integers are the edges between pixels: the centre of the
// first pixel is 0.5, and a picture of width w spans 0 to w.
struct Point {
  double x = 0, y = 0;
};

// An affine transform: source x = xx * x + xy * y + x0 and source y = yx * x + yy * y + y0 for a
// point of the tensor. It covers scaling, cropping, borders, rotation and their compositions.
struct SourceMap {
  double xx = 1, xy = 0, x0 = 0;
  double yx = 0, yy = 1, y0 = 0;
  uint32_t source_width = 0, source_height = 0;  // of the picture, in pixels
  uint32_t width = 0, height = 0;                // of the tensor, in pixels
  uint8_t x_dimension = 1, y_dimension = 2;      // of the tensor, 0 = innermost
  uint64_t row = 0;  // of the results that the region was cut out for, plus 1; 0 = not known

  Point to_source(Point tensor) const noexcept {
    return {xx * tensor.x + xy * tensor.y + x0, yx * tensor.x + yy * tensor.y + y0};
  }
  // Returns the inverse; it is not finite if the map is singular.
  Point to_tensor(Point source) const noexcept {
    const double area = xx * yy - xy * yx;
    const double x = source.x - x0, y = source.y - y0;
    return {(yy * x - xy * y) / area, (xx * y - yx * x) / area};
  }

  // Returns the map of a part cut and scaled out of this tensor: its point p is scale * p + offset
  // here.
  SourceMap of_part(double scale_x, double offset_x, double scale_y, double offset_y,
                    uint32_t part_width, uint32_t part_height) const noexcept {
    SourceMap out = *this;
    out.x0 += xx * offset_x + xy * offset_y;
    out.y0 += yx * offset_x + yy * offset_y;
    out.xx *= scale_x;
    out.yx *= scale_x;
    out.xy *= scale_y;
    out.yy *= scale_y;
    out.width = part_width;
    out.height = part_height;
    return out;
  }
};

// Conversions to and from the C struct in weir_frame.
inline weir_source_map abi_map(const SourceMap& map) noexcept {
  return {map.xx,    map.xy,     map.x0,           map.yx,
          map.yy,    map.y0,     map.source_width, map.source_height,
          map.width, map.height, map.x_dimension,  map.y_dimension,
          map.row};
}
inline SourceMap source_map(const weir_source_map& map) noexcept {
  return {map.xx,
          map.xy,
          map.x0,
          map.yx,
          map.yy,
          map.y0,
          map.source_width,
          map.source_height,
          map.width,
          map.height,
          static_cast<uint8_t>(map.x_dimension),
          static_cast<uint8_t>(map.y_dimension),
          map.row};
}
// Returns the map of tensor `index` of a frame, or of region `index` if the maps are per region; a
// single map applies to all. nullopt if the frame does not come from a picture.
inline std::optional<SourceMap> source_map(const weir_frame& frame, uint32_t index) noexcept {
  constexpr uint32_t kNeeded = offsetof(weir_frame, maps) + sizeof frame.maps;
  if (frame.struct_size < kNeeded || !frame.maps || frame.n_maps == 0) return std::nullopt;
  if (frame.n_maps == 1) return source_map(frame.maps[0]);
  return index < frame.n_maps ? std::optional(source_map(frame.maps[index])) : std::nullopt;
}

// Returns the identity map, for a picture taken as a tensor. Packed pixels are C:W:H, planes W:H:C.
inline SourceMap picture_as_it_is(uint32_t width, uint32_t height, bool planar) noexcept {
  SourceMap out;
  out.source_width = out.width = width;
  out.source_height = out.height = height;
  if (planar) out.x_dimension = 0, out.y_dimension = 1;
  return out;
}

}  // namespace weir
