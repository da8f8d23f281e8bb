// The dimension grammar and its equality (docs/compatibility/types-and-caps.md 1.4).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/tensor/shape.hpp"

#include <algorithm>

#include "core/text/text.hpp"

namespace weir {

Shape::Shape(std::span<const uint32_t> dims) noexcept {
  std::copy_n(dims.begin(), std::min(dims.size(), kRankLimit), dims_.begin());
}

Shape::Shape(std::initializer_list<uint32_t> dims) noexcept
    : Shape(std::span(dims.begin(), dims.size())) {}

Shape Shape::parse(std::string_view text) noexcept {
  Shape shape;
  for (size_t i = 0; i < kRankLimit; ++i) {
    // The 16th part takes the rest as written: a number followed by more is not a number.
    const size_t colon = i + 1 < kRankLimit ? text.find(':') : std::string_view::npos;
    const auto part = strip(text.substr(0, colon));
    if (part.empty()) break;
    const auto value = parse_unsigned(part);
    shape.dims_[i] = value && *value <= UINT32_MAX ? static_cast<uint32_t>(*value) : 0;
    if (colon == std::string_view::npos) break;
    text.remove_prefix(colon + 1);
  }
  return shape;
}

size_t Shape::rank() const noexcept {
  return static_cast<size_t>(std::find(dims_.begin(), dims_.end(), 0u) - dims_.begin());
}

size_t Shape::min_rank() const noexcept {
  size_t rank = this->rank();
  while (rank > 1 && dims_[rank - 1] == 1) --rank;
  return std::max<size_t>(rank, 1);
}

bool Shape::valid() const noexcept {
  const size_t rank = this->rank();
  return rank >= 1 && std::all_of(dims_.begin() + static_cast<std::ptrdiff_t>(rank), dims_.end(),
                                  [](uint32_t d) { return d == 0; });
}

std::optional<uint64_t> Shape::count() const noexcept {
  const size_t rank = this->rank();
  uint64_t product = rank > 0 ? 1 : 0;
  for (size_t i = 0; i < rank; ++i)
    if (__builtin_mul_overflow(product, uint64_t{dims_[i]}, &product) || product > INT64_MAX)
      return std::nullopt;
  return product;
}

std::string Shape::to_string(size_t min_entries) const {
  const size_t rank = this->rank();
  std::string out;
  for (size_t i = 0; i < std::max(rank, rank ? min_entries : 0); ++i) {
    if (i > 0) out += ':';
    out += std::to_string(i < rank ? dims_[i] : 1);
  }
  return out;
}

Shape Shape::with_rank(size_t rank) const noexcept {
  Shape out;
  for (size_t i = 0; i < std::min(rank, kRankLimit); ++i) out.dims_[i] = std::max(dims_[i], 1u);
  return out;
}

bool Shape::operator==(const Shape& other) const noexcept {
  return valid() && other.valid() &&
         std::equal(dims_.begin(), dims_.end(), other.dims_.begin(),
                    [](uint32_t a, uint32_t b) { return a == b || (a <= 1 && b <= 1); });
}

}  // namespace weir
