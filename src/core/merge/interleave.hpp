// Rows of a few bytes: a block of each input, one behind the other.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <span>

namespace weir {

// Writes the first rows of `rows` to `out`, and returns how many these are: none where rows are not
// made by shuffles (more than 16 bytes in a row, or other than 2 to 4 inputs), and never the last
// ones, for vectors are read and written whole. `blocks`: bytes of each input in a row.
size_t interleave_rows(std::span<const std::span<const std::byte>> inputs,
                       std::span<const size_t> blocks, size_t rows, std::byte* out) noexcept;

}  // namespace weir
