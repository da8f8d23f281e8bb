// Sums of many whole numbers of 8 and 16 bits, as fast as memory brings them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace weir::condition {

// Exact for as many as memory holds. `bytes` are numbers of 8 bits, or of 16 bits at any address.
int64_t sum_of_bytes(std::span<const std::byte> bytes, bool are_signed) noexcept;
int64_t sum_of_words(std::span<const std::byte> bytes, bool are_signed) noexcept;

}  // namespace weir::condition
