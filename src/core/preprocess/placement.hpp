// Placement: which part of a picture goes to which part of a tensor, and the way back.
#pragma once
#include "core/preprocess/preparation.hpp"

namespace weir::preprocess {

struct Point {
  double x = 0, y = 0;
};

// source = scale * tensor + offset for each axis, in pixels from the left upper corner; whole
// numbers are edges between pixels, the middle of the first pixel is 0.5.
struct SourceMap {
  double scale_x = 1, scale_y = 1;  // source pixels for one of the tensor, above 0
  double offset_x = 0, offset_y = 0;

  Point to_source(Point tensor) const noexcept {
    return {scale_x * tensor.x + offset_x, scale_y * tensor.y + offset_y};
  }
  Point to_tensor(Point source) const noexcept {
    return {(source.x - offset_x) / scale_x, (source.y - offset_y) / scale_y};
  }
};

struct Placement {
  Rect source;   // in the picture
  Rect content;  // in the tensor; what is around it is padding

  SourceMap map() const noexcept;
};

// Precondition: check(preparation). Parts are whole pixels: letterboxed content is rounded to the
// nearest size and, as a centred crop, lies at most half a pixel left of and above the middle.
Placement place(const Preparation& preparation) noexcept;

}  // namespace weir::preprocess
