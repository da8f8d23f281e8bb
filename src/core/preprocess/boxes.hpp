// Boxes: reads the regions of a picture from a tensor.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/preprocess/preparation.hpp"

namespace weir::preprocess {

// SPEC_MISMATCH unless the tensor is uint32 or float32 4:N (further dimensions of 1): x, y, width
// and height of each box.
Status check_boxes(const TensorSpec& spec);
// Precondition: check_boxes(). `bytes` are the tensor's and may have any alignment. Edges are
// rounded to whole pixels. A box that is not finite or has no area becomes empty (width 0).
void read_boxes(const TensorSpec& spec, std::span<const std::byte> bytes, std::vector<Box>* out);

// The intersection of the box with `whole`; sides of 0 if there is none.
Rect common_part(const Rect& whole, const Box& box) noexcept;

}  // namespace weir::preprocess
