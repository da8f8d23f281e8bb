// Boxes: the regions of a picture as a tensor names them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/preprocess/preparation.hpp"

namespace weir::preprocess {

// SPEC_MISMATCH unless it is uint32 or float32 4:N (further dimensions of 1): x, y, width, height
// of each box.
Status check_boxes(const TensorSpec& spec);
// Precondition: check_boxes(); `bytes` are the tensor's, any alignment. Edges that are no whole
// pixel go to the nearest; a box that is not finite or has no area is empty (a width of 0).
void read_boxes(const TensorSpec& spec, std::span<const std::byte> bytes, std::vector<Box>* out);

// The part of the box in `whole`; empty (sides of 0) when they do not meet.
Rect common_part(const Rect& whole, const Box& box) noexcept;

}  // namespace weir::preprocess
