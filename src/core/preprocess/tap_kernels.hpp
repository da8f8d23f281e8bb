// Filter taps: the row loops that make each pixel from any number of samples. padded() and
// kRowBlock are in row_kernels.hpp.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>

namespace weir::preprocess {

// The source rows that make one row of the tensor.
//
// CPUs do not prefetch across pages. While a kernel computes one row of the tensor, it therefore
// prefetches the source rows of the next one, a little in each step, because many requests at once
// would stall it.
struct SourceRows {
  const uint8_t* const* rows = nullptr;  // `count` rows
  // The rows after them, as many and readable to the same length; may equal `rows`.
  const uint8_t* const* next = nullptr;
  size_t count = 0;
};

// out[i] = sum over k of weights[k] * from.rows[k][i], for exactly `bytes` elements.
void blend_rows(const SourceRows& from, const float* weights, size_t bytes, float* out) noexcept;

// out[i] = sum over k of weights[k * stride + i] * in[index[k * stride + i]] with stride =
// padded(count). Index, weights and `out` extend to the stride.
void gather_row(const float* in, const int32_t* index, const float* weights, size_t taps,
                size_t count, float* out) noexcept;

}  // namespace weir::preprocess
