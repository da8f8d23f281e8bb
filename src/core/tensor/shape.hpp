// Shape: the dimensions of a tensor, innermost (fastest varying) first as in caps and headers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "weir/result.hpp"

namespace weir {

inline constexpr size_t kRankLimit = 16;

class Shape {
 public:
  Shape() = default;
  // Keeps at most kRankLimit dimensions.
  explicit Shape(std::span<const uint32_t> dims) noexcept;
  Shape(std::initializer_list<uint32_t> dims) noexcept;
  // "3:224:224:1". Ignores blanks around parts, stops at the first empty part, and reads a part
  // that is not a number as 0 (the result may then be invalid: see valid()).
  static Shape parse(std::string_view text) noexcept;

  uint32_t operator[](size_t i) const noexcept { return dims_[i]; }  // 0 beyond the rank
  uint32_t& operator[](size_t i) noexcept { return dims_[i]; }
  const std::array<uint32_t, kRankLimit>& dims() const noexcept { return dims_; }
  // Makes the first `rank` entries, at most kRankLimit, dimensions also where they are 0: "2:0" has
  // no rows of two, and no elements. Such tensors occur in flexible streams and in frames of
  // modules, never in caps.
  void set_rank(size_t rank) noexcept;
  size_t rank() const noexcept;      // leading non-zero entries, or set_rank()
  bool is_empty() const noexcept;    // has dimensions, and one of them is 0
  size_t min_rank() const noexcept;  // rank without trailing ones, at least 1
  bool valid() const noexcept;       // rank >= 1 and only zeros after it
  // Product of the dimensions, 0 without any; nullopt if it exceeds 63 bits.
  std::optional<uint64_t> count() const noexcept;
  // The dimensions joined by ':', padded with ":1" up to min_entries.
  std::string to_string(size_t min_entries = 0) const;
  // First `rank` dimensions; missing ones become 1. For caps.
  Shape with_rank(size_t rank) const noexcept;
  // docs/compatibility/types-and-caps.md 1.4: both valid, entries equal or both 1 or not given.
  bool operator==(const Shape& other) const noexcept;

 private:
  std::array<uint32_t, kRankLimit> dims_{};
  size_t set_rank_ = 0;
};

}  // namespace weir
