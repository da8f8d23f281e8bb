// Boxes: reads the regions of a picture from a tensor.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/preprocess/preparation.hpp"
#include "core/tensor/geometry.hpp"
#include "weir/detection.hpp"
#include "weir/results.h"

namespace weir::preprocess {

// How the region of a box differs from the box. First the centre is moved by parts of the sides,
// then the longer side counts for both, then both are multiplied.
struct RegionShape {
  double shift_x = 0, shift_y = 0;  // along the sides of the box, as it is rotated
  bool is_square = false;
  double scale = 1;
  bool follows_rotation = false;  // otherwise the region is the upright box around a rotated one
  bool operator==(const RegionShape&) const = default;
};
// The region of a box, rotated clockwise about its centre. Edges are rounded to whole pixels. Empty
// if a number is not finite or there is no area.
Roi make_region(const weir::Box& box, float rotation, const RegionShape& shape);
// The same for an upright region.
Roi make_region(const Roi& region, const RegionShape& shape);

// SPEC_MISMATCH unless the tensor is uint32 or float32 4:N (further dimensions of 1): x, y, width
// and height of each box.
Status check_boxes(const TensorSpec& spec);
// Precondition: check_boxes(). `bytes` are the tensor's and may have any alignment. Edges are
// rounded to whole pixels. A box that is not finite or has no area becomes empty (width 0).
void read_boxes(const TensorSpec& spec, std::span<const std::byte> bytes, std::vector<Roi>* out,
                const RegionShape& shape = {});

// The boxes of result rows (weir/results.h) with these columns. SPEC_MISMATCH unless the tensor is
// float32 L:N with the L of the columns.
Status check_result_rows(const TensorSpec& spec, const weir_result_columns& columns);
// Precondition: check_result_rows(). Appends the region of each row, numbered from `first_row`,
// except background. Rows without a box give none.
void read_result_boxes(const weir_result_columns& columns, std::span<const std::byte> bytes,
                       uint64_t first_row, std::vector<Roi>* out, const RegionShape& shape = {});

// Regions in pixels of a picture of this size; 0 x 0: not known.
struct PictureRegions {
  std::vector<Roi> boxes;
  Size picture;
};
// The regions in pixels of the same picture in another size.
std::vector<Roi> scaled_to(Size picture, const PictureRegions& regions);

// The intersection of the box with `whole`; sides of 0 if there is none.
Rect common_part(const Rect& whole, const Roi& box) noexcept;

}  // namespace weir::preprocess
