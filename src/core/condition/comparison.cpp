// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/condition/comparison.hpp"

#include <algorithm>
#include <concepts>
#include <cstring>
#include <string>

#include "core/condition/narrow_sum.hpp"
#include "core/split/pick_list.hpp"
#include "core/transform/number_rules.hpp"

namespace weir::condition {
namespace {

template <class T>
T cast(double x) noexcept {
  if constexpr (std::same_as<T, uint64_t>)
    if (x >= 0x1p63) return x < 0x1p64 ? static_cast<uint64_t>(x) : UINT64_MAX;
  return transform::convert_operand<T>(x);
}
template <class T>
T cast(const Number& number) noexcept {
  return number.is_real ? cast<T>(number.real) : transform::convert_operand<T>(number.whole);
}

template <class T>
bool compare(Operator op, T x, T first, T second) noexcept {
  switch (op) {
    case Operator::Equal:
      return x == first;
    case Operator::NotEqual:
      return x != first;
    case Operator::Greater:
      return x > first;
    case Operator::GreaterOrEqual:
      return x >= first;
    case Operator::Less:
      return x < first;
    case Operator::LessOrEqual:
      return x <= first;
    case Operator::InRange:
      return first <= x && x <= second;
    case Operator::InsideRange:
      return first < x && x < second;
    case Operator::NotInRange:
      return x < first || second < x;
    case Operator::NotInsideRange:
      return x <= first || second <= x;
  }
  return false;
}

template <class T>
T element_at(std::span<const std::byte> bytes, size_t index) noexcept {
  T value;
  std::memcpy(&value, bytes.data() + index * sizeof(T), sizeof(T));
  return value;
}

// Sums of integers up to 32 bits are exact for any number of elements that fits into memory.
template <class T>
double sum_of_wide(std::span<const std::byte> bytes) noexcept {
  constexpr size_t kLanes = 8;  // independent sums hide the latency of additions
  using Sum = std::conditional_t<std::integral<T> && sizeof(T) <= 4, int64_t, double>;
  Sum lanes[kLanes] = {};
  const size_t count = bytes.size() / sizeof(T);
  size_t i = 0;
  for (; i + kLanes <= count; i += kLanes)
    for (size_t lane = 0; lane < kLanes; ++lane)
      lanes[lane] += static_cast<Sum>(element_at<T>(bytes, i + lane));
  for (; i < count; ++i) lanes[i % kLanes] += static_cast<Sum>(element_at<T>(bytes, i));
  Sum total = 0;
  for (const Sum lane : lanes) total += lane;
  return static_cast<double>(total);
}

template <class T>
double sum(std::span<const std::byte> bytes) noexcept {
  if constexpr (std::integral<T> && sizeof(T) == 1)
    return static_cast<double>(sum_of_bytes(bytes, std::signed_integral<T>));
  else if constexpr (std::integral<T> && sizeof(T) == 2)
    return static_cast<double>(sum_of_words(bytes, std::signed_integral<T>));
  else
    return sum_of_wide<T>(bytes);
}

Result<size_t> element_index(const Place& place, const TensorSpec& tensor) {
  size_t index = 0, step = 1;
  if (tensor.shape.is_empty()) return index;  // there is nothing to compare
  for (size_t d = 0; d < kRankLimit; ++d) {
    const uint32_t extent = std::max(tensor.shape[d], 1u);
    if (place.coordinate[d] >= extent)
      return Error{
          .code = Code::OPTION_VALUE,
          .what = "compared-value-option names an element that does not exist",
          .offered = "coordinate " + std::to_string(place.coordinate[d]) + " in dimension " +
                     std::to_string(d),
          .needed = "below " + std::to_string(extent),
          .difference = "tensor " + std::to_string(place.tensor) + " is " + tensor.to_string(),
          .fix = "compared-value-option=0:0:0:0," + std::to_string(place.tensor)};
    index += place.coordinate[d] * step;
    step *= extent;
  }
  return index;
}

}  // namespace

double average(ElementType type, std::span<const std::byte> bytes) noexcept {
  return visit_type(type, [&]<class T>(std::type_identity<T>) {
    const size_t elements = bytes.size() / sizeof(T);
    return sum<T>(bytes) / static_cast<double>(elements);
  });
}

Result<Comparison> Comparison::make(const Condition& condition,
                                    const std::vector<TensorSpec>& tensors) {
  const Place& place = *condition.place;
  if (place.tensor >= tensors.size()) {
    Error error = index_beyond("compared-value-option", "tensor", place.tensor, tensors.size());
    if (condition.compared == ComparedValue::Element) error.fix = "compared-value-option=0:0:0:0,0";
    return error;
  }
  const TensorSpec& tensor = tensors[place.tensor];
  const auto bytes = tensor.bytes();
  if (!bytes)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "a tensor is too large",
                 .offered = tensor.to_string(),
                 .needed = "at most 2^63 bytes"};
  Comparison out;
  out.condition_ = condition;
  out.condition_.supplied.resize(2);
  out.type_ = tensor.type;
  out.tensor_ = place.tensor;
  out.bytes_ = static_cast<size_t>(*bytes);
  if (condition.compared == ComparedValue::Average) return out;
  const auto index = element_index(place, tensor);
  if (!index) return index.error();
  out.bytes_ = element_size(tensor.type);
  out.offset_ = *index * out.bytes_;
  return out;
}

bool Comparison::holds(std::span<const std::byte> bytes) const noexcept {
  return visit_type(type_, [&]<class T>(std::type_identity<T>) {
    const T value = condition_.compared == ComparedValue::Average ? cast<T>(average(type_, bytes))
                                                                  : element_at<T>(bytes, 0);
    return compare(condition_.op, value, cast<T>(condition_.supplied[0]),
                   cast<T>(condition_.supplied[1]));
  });
}

}  // namespace weir::condition
