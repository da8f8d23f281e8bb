// Pixels that are sums of any number of samples: the loops over one row. padded() and kRowBlock:
// row_kernels.hpp.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>

#include "core/preprocess/source_rows.hpp"

namespace weir::preprocess {

// out[i] = sum over k of weights[k] * from.rows[k][i], for exactly `bytes` elements. With one row
// its weight is not read: it is 1.
void blend_rows(const SourceRows& from, const float* weights, size_t bytes, float* out) noexcept;

// out[i] = sum over k of weights[k * stride + i] * in[index[k * stride + i]], stride being
// padded(count). With one tap the weights are not read: they are 1. The index falls neither from i
// to i + 1, up to the stride, nor from tap to tap. `in` is readable up to kRowBlock elements behind
// the largest index, `out` is writable up to the stride.
void gather_row(const float* in, const int32_t* index, const float* weights, size_t taps,
                size_t count, float* out) noexcept;
// The same of pixels of three or four lanes side by side: lane l to out[l]. All four are written:
// of three lanes the fourth is any.
void gather_pixels(const float* in, const int32_t* index, const float* weights, size_t taps,
                   size_t count, float* const* out) noexcept;

}  // namespace weir::preprocess
