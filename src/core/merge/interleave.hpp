// interleave_rows: builds short rows from one block of each input.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <span>

namespace weir {

// Writes the first ones of `rows` rows to `out` and returns their number. Returns 0 if shuffles
// cannot make the rows (more than 16 bytes in a row, or not 2 to 4 inputs). Never writes the last
// rows, because it accesses whole vectors. `blocks`: bytes of each input in a row.
size_t interleave_rows(std::span<const std::span<const std::byte>> inputs,
                       std::span<const size_t> blocks, size_t rows, std::byte* out) noexcept;

}  // namespace weir
