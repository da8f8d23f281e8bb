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

void Shape::set_rank(size_t rank) noexcept {
  set_rank_ = std::min(rank, kRankLimit);
}

bool Shape::is_empty() const noexcept {
  return set_rank_ > 0 && count() == 0;
}

size_t Shape::rank() const noexcept {
  if (set_rank_ > 0) return set_rank_;
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
  rank = std::min(rank, kRankLimit);
  const size_t given = std::min(rank, this->rank());
  std::copy_n(dims_.begin(), given, out.dims_.begin());
  std::fill(out.dims_.begin() + given, out.dims_.begin() + rank, 1u);
  if (set_rank_ > 0) out.set_rank(rank);
  return out;
}

bool Shape::operator==(const Shape& other) const noexcept {
  if (!valid() || !other.valid()) return false;
  const size_t rank = this->rank(), other_rank = other.rank();
  for (size_t i = 0; i < std::max(rank, other_rank); ++i)
    if ((i < rank ? dims_[i] : 1) != (i < other_rank ? other.dims_[i] : 1)) return false;
  return true;
}

}  // namespace weir
