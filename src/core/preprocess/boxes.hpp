// Boxes: reads the regions of a picture from a tensor.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
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
// A box in pixels of a picture, which its edges may lie between.
struct PictureBox {
  double left = 0, top = 0, right = 0, bottom = 0;
  double rotation = 0;  // clockwise about its centre, in radians
  uint64_t row = 0;     // as in Roi
};
// The upright box around it.
PictureBox make_upright(const PictureBox& box) noexcept;

// Factors from one picture to another.
struct PictureScale {
  double x = 1, y = 1;
};
// The factors from boxes of one picture to another one, 1 if a size is not known (0 x 0). nullopt
// if the other may be a part that was cut out of the one: it is not larger, and its sides have
// other factors, also where its pixels are not square. `pixel_aspect` is their width by their
// height.
std::optional<PictureScale> find_scale(Size from, Size to, double pixel_aspect) noexcept;
// A warning about boxes that are used as they are, because find_scale() found no factors.
Error boxes_of_another_view(Size from, Size to);

// The region of a box that is scaled to another picture first. Then its edges are rounded to whole
// pixels. Empty if a number is not finite or there is no area.
Roi make_region(const PictureBox& box, const RegionShape& shape, const PictureScale& scale = {});

// SPEC_MISMATCH unless the tensor is uint32 or float32 4:N (further dimensions of 1): x, y, width
// and height of each box.
Status check_boxes(const TensorSpec& spec);
// Precondition: check_boxes(). `bytes` are the tensor's and may have any alignment.
void read_boxes(const TensorSpec& spec, std::span<const std::byte> bytes,
                std::vector<PictureBox>* out);

// The boxes of result rows (weir/results.h) with these columns. SPEC_MISMATCH unless the tensor is
// float32 L:N with the L of the columns.
Status check_result_rows(const TensorSpec& spec, const weir_result_columns& columns);
// Precondition: check_result_rows(). Appends the box of each row, numbered from `first_row`, except
// background. Rows without a box give none.
void read_result_boxes(const weir_result_columns& columns, std::span<const std::byte> bytes,
                       uint64_t first_row, std::vector<PictureBox>* out);

// Boxes in pixels of a picture of this size; 0 x 0: not known.
struct PictureRegions {
  std::vector<PictureBox> boxes;
  Size picture;
};

// The intersection of the box with `whole`; sides of 0 if there is none.
Rect common_part(const Rect& whole, const Roi& box) noexcept;

}  // namespace weir::preprocess
