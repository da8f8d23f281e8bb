// RotatedPart: samples a rotated region of a picture, which no pair of axes can do.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <utility>

#include "core/preprocess/preparation.hpp"
#include "weir/source_map.hpp"

namespace weir::preprocess {

class RotatedPart {
 public:
  // `part`, relative to the region's corner before it is rotated, fills `content` of the tensor.
  // Pixels come from `picture`, a part of the picture in memory.
  RotatedPart(const Roi& region, const Rect& part, const Rect& content,
              const Rect& picture) noexcept;

  // The pixels of a row of the tensor whose centre is in the picture: from first to second - 1.
  std::pair<uint32_t, uint32_t> columns_inside(uint32_t row) const noexcept;
  bool shows_picture() const noexcept;
  const Rect& picture() const noexcept { return picture_; }
  // From the tensor to the picture.
  Point to_source(Point tensor) const noexcept {
    return {xx_ * tensor.x + xy_ * tensor.y + x0_, yx_ * tensor.x + yy_ * tensor.y + y0_};
  }
  // Sets the transform of `map`.
  void set_transform(SourceMap* map) const noexcept {
    map->xx = xx_, map->xy = xy_, map->x0 = x0_;
    map->yx = yx_, map->yy = yy_, map->y0 = y0_;
  }
  // Source pixels for each pixel of the tensor, along both sides of the region.
  double step_x() const noexcept { return step_x_; }
  double step_y() const noexcept { return step_y_; }

 private:
  // Whether the upright box around all of it meets the picture.
  bool may_show_picture() const noexcept;

  double xx_, xy_, x0_, yx_, yy_, y0_;
  double step_x_, step_y_;
  Rect content_, picture_;
};

// The samples of a component: `rows` is its first byte of row 0 of the plane in memory.
struct ComponentRows {
  const uint8_t* rows = nullptr;
  ptrdiff_t stride = 0;
  Component component;
  bool is_cosited_in_columns = false, is_cosited_in_rows = false;
};
// The samples that cover `picture` along one side of it.
std::pair<uint32_t, uint32_t> samples_of(uint32_t begin, uint32_t length, bool halved) noexcept;

// Writes the numbers of the component for the pixels [from, to) of a row of the tensor.
// bilinear and nearest as in preparation.hpp; area: the mean over points spread over the pixel, at
// most 16 along each side.
void sample_row(const RotatedPart& part, const ComponentRows& in, Resize resize, uint32_t row,
                std::pair<uint32_t, uint32_t> columns, float* out) noexcept;

}  // namespace weir::preprocess
