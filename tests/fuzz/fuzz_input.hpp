// FuzzInput: reads the bytes of one fuzz input from front to back; require() reports a violated
// invariant.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>

namespace weir::fuzz {

class FuzzInput {
 public:
  FuzzInput(const uint8_t* data, size_t size) : rest_(std::as_bytes(std::span(data, size))) {}

  // The next bytes in native byte order; bytes past the end read as 0.
  template <class T>
  T take() requires std::is_arithmetic_v<T> {
    T value{};
    const auto part = bytes(sizeof value);
    if (!part.empty()) std::memcpy(&value, part.data(), part.size());
    return value;
  }
  uint8_t byte() { return take<uint8_t>(); }
  // A number from 0 to `count` - 1.
  uint32_t below(uint32_t count) { return byte() % count; }
  bool flag() { return byte() % 2 == 1; }
  // True one time in 16, and never past the end.
  bool rarely() { return byte() % 16 == 15; }

  // The next bytes; fewer at the end.
  std::span<const std::byte> bytes(size_t size) {
    const auto part = rest_.first(std::min(size, rest_.size()));
    rest_ = rest_.subspan(part.size());
    return part;
  }
  // Reads to the next newline, which is skipped.
  std::string_view line() {
    const std::string_view all = text();
    const std::string_view out = all.substr(0, all.find('\n'));
    bytes(out.size() + 1);
    return out;
  }
  // The bytes not read yet.
  std::span<const std::byte> rest() const noexcept { return rest_; }
  std::string_view text() const noexcept {
    return {reinterpret_cast<const char*>(rest_.data()), rest_.size()};
  }
  bool empty() const noexcept { return rest_.empty(); }

 private:
  std::span<const std::byte> rest_;
};

// Whether a * b equals `product`, even beyond 64 bits.
inline bool multiplies_to(uint64_t a, uint64_t b, uint64_t product) {
  uint64_t out = 0;
  return !__builtin_mul_overflow(a, b, &out) && out == product;
}

inline void require(bool holds, const char* law) {
  if (holds) return;
  std::fprintf(stderr, "broken: %s\n", law);
  std::abort();
}

}  // namespace weir::fuzz
