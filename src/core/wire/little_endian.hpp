// Reads and writes little-endian numbers at offsets of a byte sequence.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

namespace weir::wire {

// Precondition: offset + sizeof(T) <= bytes.size().
template <class T>
T read_little(std::span<const std::byte> bytes, size_t offset) requires std::is_integral_v<T> {
  std::make_unsigned_t<T> value = 0;
  for (size_t i = sizeof(T); i-- > 0;)
    value = static_cast<std::make_unsigned_t<T>>(uint64_t{value} << 8 |
                                                 std::to_integer<uint64_t>(bytes[offset + i]));
  return static_cast<T>(value);
}

// Precondition: offset + sizeof(T) <= bytes.size().
template <class T>
void write_little(std::span<std::byte> bytes, size_t offset,
                  T value) requires std::is_integral_v<T> {
  const auto number = static_cast<uint64_t>(value);
  for (size_t i = 0; i < sizeof(T); ++i)
    bytes[offset + i] = static_cast<std::byte>(number >> (8 * i) & 0xFF);
}

}  // namespace weir::wire
