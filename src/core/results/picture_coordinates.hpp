// Moves objects, and the grids of masks and class maps, from the coordinates of a model's input to
// those of the source picture.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>

#include "core/detection/candidate.hpp"
#include "core/results/frame_results.hpp"
#include "core/tensor/geometry.hpp"
#include "weir/detection.hpp"
#include "weir/source_map.hpp"

namespace weir::results {

// RotatedGrid: where the elements of a mask or class map come from if the tensor's pixels are
// turned or mirrored in the source picture.

// Whether rows of the tensor are rows of the picture, in the same direction: grids stay as they
// are.
bool keeps_directions(const SourceMap& map) noexcept;

// The upright box around a box of the tensor.
Box upright_box(const SourceMap& map, const Box& box) noexcept;

// A grid over the upright box around a box of the tensor, whose elements lie over those of a grid
// over that box. After a quarter turn each element lies over exactly one.
class RotatedGrid {
 public:
  // Precondition: both sizes of `grid` are above 0.
  RotatedGrid(const SourceMap& map, const Box& box, Size grid) noexcept;

  const Box& box() const noexcept { return upright_; }  // in the picture
  Size size() const noexcept { return size_; }
  // The place of an element's centre in the original grid, whose first element spans 0 to 1.
  // nullopt outside of it.
  std::optional<Point> find_point(uint32_t column, uint32_t row) const noexcept;

 private:
  SourceMap map_;
  Box box_, upright_;
  Size grid_, size_;
};

// Moves objects from the coordinates of a model's input to those of the source picture.

// The object of a candidate in pixels of the model's input. The box of a candidate with an angle
// has its centre at the candidate's x, y.
Object make_object(const detection::Candidate& candidate, bool is_rotated) noexcept;

// Applies the map to boxes, rotations, key points and masks. Under a map that rotates, an upright
// box becomes the upright box around it, and its mask is turned and spans that box; unless
// `is_rotated`: then the box turns with the picture, and its mask with it.
void move_to_picture(const SourceMap& map, bool is_rotated, FrameResults* results);

}  // namespace weir::results
