// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/transpose_steps.hpp"

#include <algorithm>
#include <cstring>

namespace weir::transform {
namespace {

struct Axes {
  std::array<TransposeAxis, kRankLimit> axis;
  size_t count = 0;
};

// The output's axes without those of size 1; adjacent axes that are also adjacent in the input are
// merged.
Axes merged_axes(const Shape& in, std::span<const uint8_t, kRankLimit> order) noexcept {
  std::array<size_t, kRankLimit> in_stride{};
  size_t stride = 1;
  for (size_t i = 0; i < kRankLimit; ++i) {
    in_stride[i] = stride;
    stride *= std::max<size_t>(in[i], 1);
  }
  Axes axes;
  for (const uint8_t source : order) {
    const size_t size = std::max<size_t>(in[source], 1);
    if (size == 1) continue;
    TransposeAxis* last = axes.count > 0 ? &axes.axis[axes.count - 1] : nullptr;
    if (last != nullptr && in_stride[source] == last->in_stride * last->size)
      last->size *= size;
    else
      axes.axis[axes.count++] = {size, in_stride[source], 1};
  }
  return axes;
}

// Data that is contiguous on both sides becomes the element.
void fold_contiguous(Axes& axes, size_t& element_bytes) noexcept {
  if (axes.count == 0 || axes.axis[0].in_stride != 1) return;
  const size_t length = axes.axis[0].size;
  element_bytes *= length;
  --axes.count;
  for (size_t i = 0; i < axes.count; ++i) {
    axes.axis[i] = axes.axis[i + 1];
    axes.axis[i].in_stride /= length;  // all others step over the whole run
  }
}

}  // namespace

TransposeSteps make_transpose_steps(const Shape& in, std::span<const uint8_t, kRankLimit> order,
                                    size_t element_bytes) noexcept {
  auto axes = merged_axes(in, order);
  TransposeSteps steps;
  steps.element_bytes = element_bytes;
  fold_contiguous(axes, steps.element_bytes);
  steps.copy = axes.count == 0;
  if (steps.copy) return steps;
  size_t out_stride = 1;
  for (size_t i = 0; i < axes.count; ++i) {
    axes.axis[i].out_stride = out_stride;
    out_stride *= axes.axis[i].size;
  }
  steps.row = axes.axis[0];
  for (size_t i = 1; i < axes.count; ++i) {
    if (axes.axis[i].in_stride == 1)
      steps.column = axes.axis[i];
    else
      steps.outer[steps.outer_count++] = axes.axis[i];
  }
  return steps;
}

void run_transpose_plain(const TransposeSteps& steps, const std::byte* in,
                         std::byte* out) noexcept {
  const size_t bytes = steps.element_bytes;
  for_each_plane(steps, in, out, [&](const std::byte* from, std::byte* to) {
    for (size_t c = 0; c < steps.column.size; ++c)
      for (size_t r = 0; r < steps.row.size; ++r)
        std::memcpy(to + (c * steps.column.out_stride + r) * bytes,
                    from + (r * steps.row.in_stride + c) * bytes, bytes);
  });
}

}  // namespace weir::transform
