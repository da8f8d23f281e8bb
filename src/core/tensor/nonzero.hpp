// NonzeroElements: counts and extracts the elements of a dense tensor that are not zero.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>

namespace weir {

// Treats elements as unsigned numbers of `size` bytes (1, 2, 4 or 8). With `is_signed` the highest
// bit is ignored, so that minus zero counts as zero.
struct NonzeroElements {
  size_t size = 1;
  bool is_signed = false;

  size_t count(const std::byte* dense, size_t elements) const noexcept;
  // Writes the first `max` of them: `values` of `size` bytes, `indices` of 4 bytes. Never writes
  // more, even if another thread changes `dense` meanwhile. Returns how many there were.
  size_t write(const std::byte* dense, size_t elements, size_t max, std::byte* values,
               std::byte* indices) const noexcept;
};

}  // namespace weir
