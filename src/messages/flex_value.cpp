// SPDX-License-Identifier: LGPL-2.1-or-later
#include "messages/flex_value.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

static_assert(std::endian::native == std::endian::little, "FlexBuffers are little-endian");

namespace weir::messages {
namespace {

enum Type : uint8_t {
  kInt = 1,
  kUInt = 2,
  kIndirectInt = 6,
  kIndirectUInt = 7,
  kMap = 9,
  kVector = 10,
  kVectorInt = 11,
  kVectorUInt = 12,
  kVectorInt2 = 16,
  kVectorUInt2 = 17,
  kVectorInt3 = 19,
  kVectorUInt3 = 20,
  kVectorInt4 = 22,
  kVectorUInt4 = 23,
  kBlob = 25,
};

// The elements of a typed vector of fixed length; 0 for other types.
size_t fixed_length(uint8_t type) {
  if (type == kVectorInt2 || type == kVectorUInt2) return 2;
  if (type == kVectorInt3 || type == kVectorUInt3) return 3;
  return type == kVectorInt4 || type == kVectorUInt4 ? 4 : 0;
}
template <class T>
uint64_t load(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return value;
}
bool is_signed_vector(uint8_t type) {
  return type == kVectorInt || type == kVectorInt2 || type == kVectorInt3 || type == kVectorInt4;
}

}  // namespace

std::optional<FlexValue> FlexValue::root(std::span<const std::byte> buffer) noexcept {
  if (buffer.size() < 3) return {};
  const auto width = static_cast<size_t>(buffer[buffer.size() - 1]);
  const auto type = static_cast<uint8_t>(buffer[buffer.size() - 2]);
  const bool known = width == 1 || width == 2 || width == 4 || width == 8;
  if (!known || width > buffer.size() - 2) return {};
  return FlexValue(buffer, buffer.size() - 2 - width, width, type);
}

std::optional<uint64_t> FlexValue::number(size_t at, size_t width) const noexcept {
  if (!has(at, width)) return {};
  const std::byte* from = buffer_.data() + at;
  switch (width) {  // a copy of a size that is not known is a call
    case 1:
      return load<uint8_t>(from);
    case 2:
      return load<uint16_t>(from);
    case 4:
      return load<uint32_t>(from);
    default:
      return load<uint64_t>(from);
  }
}

std::optional<int64_t> FlexValue::signed_number(size_t at, size_t width) const noexcept {
  const auto value = number(at, width);
  if (!value) return {};
  const auto unused = static_cast<unsigned>(64 - 8 * width);
  return static_cast<int64_t>(*value << unused) >> unused;
}

std::optional<size_t> FlexValue::follow(size_t at, size_t width) const noexcept {
  const auto offset = number(at, width);
  if (!offset || *offset > at) return {};
  return at - static_cast<size_t>(*offset);
}

std::optional<size_t> FlexValue::length_before(size_t first,
                                               uint64_t element_bytes) const noexcept {
  if (first < width()) return {};
  const auto count = number(first - width(), width());
  if (!count || *count > buffer_.size() || !has(first, *count * element_bytes)) return {};
  return static_cast<size_t>(*count);
}

bool FlexValue::is_map() const noexcept {
  return type() == kMap;
}

std::optional<FlexElements> FlexValue::elements() const noexcept {
  const auto first = target();
  if (!first) return {};
  const auto number_type = static_cast<uint8_t>((is_signed_vector(type()) ? kInt : kUInt) << 2);
  if (const size_t fixed = fixed_length(type())) {
    if (!has(*first, fixed * width())) return {};
    return FlexElements(*this, *first, fixed, number_type);
  }
  const bool numbers = type() == kVectorInt || type() == kVectorUInt;
  if (!numbers && type() != kVector && type() != kMap) return {};
  const auto count = length_before(*first, width() + (numbers ? 0 : 1));  // types follow
  if (!count) return {};
  FlexElements out(*this, *first, *count, numbers ? number_type : 0);
  if (is_map()) out.find_keys();
  return out;
}

FlexValue FlexElements::at(size_t index) const noexcept {
  const size_t width = of_.width();
  const uint8_t type =
      type_ != 0 ? type_ : static_cast<uint8_t>(of_.buffer_[first_ + count_ * width + index]);
  return FlexValue(of_.buffer_, first_ + index * width, width, type);
}

bool FlexElements::copy_to(std::span<uint32_t> out) const noexcept {
  // Writers make vectors of 32-bit numbers.
  if (type_ == kUInt << 2 && of_.width() == sizeof(uint32_t)) {
    std::memcpy(out.data(), of_.buffer_.data() + first_, count_ * sizeof(uint32_t));
    return true;
  }
  for (size_t i = 0; i < count_; ++i) {
    const auto number = at(i).integer();
    if (!number || *number < 0 || *number > UINT32_MAX) return false;
    out[i] = static_cast<uint32_t>(*number);
  }
  return true;
}

void FlexElements::find_keys() noexcept {
  const size_t width = of_.width();
  if (first_ < 3 * width) return;
  const auto keys = of_.follow(first_ - 3 * width, width);
  const auto step = of_.number(first_ - 2 * width, width);
  if (!keys || !step || (*step != 1 && *step != 2 && *step != 4 && *step != 8)) return;
  const auto bytes = static_cast<size_t>(*step);
  if (*keys < bytes || of_.number(*keys - bytes, bytes) != count_) return;
  first_key_ = *keys;
  key_width_ = bytes;
}

std::optional<std::string_view> FlexElements::key_at(size_t index) const noexcept {
  if (key_width_ == 0) return {};
  const auto key = of_.follow(first_key_ + index * key_width_, key_width_);
  if (!key) return {};
  // No known key is longer: the search never goes through a whole tensor.
  constexpr size_t kMax = 32;
  const auto rest = of_.buffer_.subspan(*key);
  const auto* begin = reinterpret_cast<const char*>(rest.data());
  const size_t searched = std::min(rest.size(), kMax);
  const void* zero = searched > 0 ? std::memchr(begin, 0, searched) : nullptr;
  if (!zero && searched == rest.size()) return {};
  return std::string_view(begin, zero ? static_cast<const char*>(zero) - begin : searched);
}

std::optional<int64_t> FlexValue::integer() const noexcept {
  const auto as_signed = [](std::optional<uint64_t> value) -> std::optional<int64_t> {
    if (!value || *value > INT64_MAX) return {};
    return static_cast<int64_t>(*value);
  };
  if (type() == kInt) return signed_number(at_, parent_width_);
  if (type() == kUInt) return as_signed(number(at_, parent_width_));
  const auto place = target();
  if (type() == kIndirectInt && place) return signed_number(*place, width());
  if (type() == kIndirectUInt && place) return as_signed(number(*place, width()));
  return {};
}

std::optional<std::span<const std::byte>> FlexValue::blob() const noexcept {
  const auto first = type() == kBlob ? target() : std::nullopt;
  const auto bytes = first ? length_before(*first, 1) : std::nullopt;
  if (!bytes) return {};
  return buffer_.subspan(*first, *bytes);
}

}  // namespace weir::messages
