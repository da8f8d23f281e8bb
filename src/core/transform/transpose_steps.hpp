// TransposeSteps: a transposition with adjacent axes merged and contiguous data folded into the
// element.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstddef>
#include <span>

#include "core/tensor/shape.hpp"

namespace weir::transform {

// One axis of the output. Strides are in elements.
struct TransposeAxis {
  size_t size = 1, in_stride = 1, out_stride = 1;
};

// Transposes planes: `row` is contiguous in the output, `column` in the input; `outer` holds all
// other axes. Without axes, the bytes are copied.
struct TransposeSteps {
  size_t element_bytes = 1;
  bool copy = false;
  TransposeAxis row, column;
  std::array<TransposeAxis, kRankLimit> outer;
  size_t outer_count = 0;
};

// Output dimension i is input dimension order[i]; order names each of 0..15 once.
TransposeSteps make_transpose_steps(const Shape& in, std::span<const uint8_t, kRankLimit> order,
                                    size_t element_bytes) noexcept;

// Both runners access exactly the bytes of the tensor.
void run_transpose_plain(const TransposeSteps& steps, const std::byte* in, std::byte* out) noexcept;
void run_transpose_vector(const TransposeSteps& steps, const std::byte* in,
                          std::byte* out) noexcept;

// Calls plane(in, out) with the start of each plane along the outer axes.
template <class Plane>
void for_each_plane(const TransposeSteps& steps, const std::byte* in, std::byte* out,
                    Plane&& plane) {
  std::array<size_t, kRankLimit> index{};
  size_t in_at = 0, out_at = 0;
  while (true) {
    plane(in + in_at * steps.element_bytes, out + out_at * steps.element_bytes);
    size_t axis = 0;
    for (; axis < steps.outer_count; ++axis) {
      const auto& [size, in_stride, out_stride] = steps.outer[axis];
      in_at += in_stride;
      out_at += out_stride;
      if (++index[axis] < size) break;
      in_at -= size * in_stride;
      out_at -= size * out_stride;
      index[axis] = 0;
    }
    if (axis == steps.outer_count) return;
  }
}

}  // namespace weir::transform
