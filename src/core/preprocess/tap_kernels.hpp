// Filter taps: the row loops that make each pixel from any number of samples. padded() and
// kRowBlock are in row_kernels.hpp.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>

#include "core/preprocess/source_rows.hpp"

namespace weir::preprocess {

// out[i] = sum over k of weights[k] * from.rows[k][i], for exactly `bytes` elements. The weight of
// a single row is 1 and is not read.
void blend_rows(const SourceRows& from, const float* weights, size_t bytes, float* out) noexcept;

// out[i] = sum over k of weights[k * stride + i] * in[index[k * stride + i]] with stride =
// padded(count). The weights of a single tap are 1 and are not read. The index never decreases,
// neither from i to i + 1, up to the stride, nor from tap to tap. `in` is readable up to kRowBlock
// elements after the largest index; `out` is writable up to the stride.
void gather_row(const float* in, const int32_t* index, const float* weights, size_t taps,
                size_t count, float* out) noexcept;
// The same for pixels of three or four interleaved lanes: lane l goes to out[l]. All four are
// written; for three lanes the fourth holds any value.
void gather_pixels(const float* in, const int32_t* index, const float* weights, size_t taps,
                   size_t count, float* const* out) noexcept;

}  // namespace weir::preprocess
