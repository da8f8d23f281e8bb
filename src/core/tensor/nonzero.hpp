// The elements of a dense tensor that are not zero: how many, and their values with their indices.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>

namespace weir {

// Elements as unsigned numbers of `size` bytes (1, 2, 4 or 8). With `is_signed` the highest bit
// alone is no value: minus zero is a zero.
struct NonzeroElements {
  size_t size = 1;
  bool is_signed = false;

  size_t count(const std::byte* dense, size_t elements) const noexcept;
  // The first `most` of them: `values` of `size` bytes, `indices` of 4 bytes. What is written is
  // bounded even where `dense` is changed meanwhile. Returns how many there were.
  size_t write(const std::byte* dense, size_t elements, size_t most, std::byte* values,
               std::byte* indices) const noexcept;
};

}  // namespace weir
