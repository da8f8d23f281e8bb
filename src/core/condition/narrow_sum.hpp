// Sums of many 8-bit and 16-bit integers at memory speed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace weir::condition {

// Exact for any number that fits into memory. 16-bit numbers may have any alignment.
int64_t sum_of_bytes(std::span<const std::byte> bytes, bool are_signed) noexcept;
int64_t sum_of_words(std::span<const std::byte> bytes, bool are_signed) noexcept;

}  // namespace weir::condition
