// The number rules of the transform: how an element changes its type, and add, mul and div.
// docs/compatibility/transform.md 3.11 and 3.12 have the tables. Written without branches that
// depend on data, so that compilers vectorise loops over them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <concepts>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "core/tensor/float16.hpp"

namespace weir::transform {

template <class T>
concept Number = std::integral<T> || std::floating_point<T>;

// Truncates towards zero and saturates; NaN becomes the lowest value, as on x86.
template <std::signed_integral To, std::floating_point From>
constexpr To truncate(From x) noexcept {
  constexpr From kEnd = -static_cast<From>(std::numeric_limits<To>::min());  // 2^31 or 2^63, exact
  // The highest From below kEnd, which can be cast without undefined behaviour.
  constexpr From kLast = kEnd - (std::numeric_limits<From>::digits < std::numeric_limits<To>::digits
                                     ? kEnd * std::numeric_limits<From>::epsilon() / 2
                                     : From{1});
  const From above = x >= -kEnd ? x : -kEnd;
  const To value = static_cast<To>(above < kLast ? above : kLast);
  return x >= kEnd ? std::numeric_limits<To>::max() : value;
}

template <std::integral Low, std::integral From>
constexpr From saturate(From x) noexcept {
  constexpr auto kMin = static_cast<From>(
      std::signed_integral<From> ? static_cast<int64_t>(std::numeric_limits<Low>::min()) : 0);
  constexpr auto kMax = static_cast<From>(std::numeric_limits<Low>::max());
  const From above = x < kMin ? kMin : x;
  return above > kMax ? kMax : above;
}

// The rule "to a narrower integer": uint8 wraps. Others saturate in the target's signed range, and
// the source counts as signed up to 32 bits. A uint64 source counts as unsigned; to int8 and uint16
// it wraps.
template <std::integral To, std::integral From>
constexpr To narrow(From x) noexcept {
  constexpr bool kWraps =
      std::same_as<To, uint8_t> ||
      (std::same_as<From, uint64_t> && (std::same_as<To, int8_t> || std::same_as<To, uint16_t>));
  if constexpr (kWraps) {
    return static_cast<To>(x);
  } else if constexpr (std::same_as<From, uint64_t>) {
    return static_cast<To>(saturate<std::make_signed_t<To>>(x));
  } else {
    const auto value = static_cast<std::make_signed_t<From>>(x);
    return static_cast<To>(saturate<std::make_signed_t<To>>(value));
  }
}

template <std::integral To, std::floating_point From>
constexpr To from_float(From x) noexcept {
  if constexpr (sizeof(To) == 8) {
    return static_cast<To>(truncate<int64_t>(x));
  } else if constexpr (sizeof(To) == 4) {
    return static_cast<To>(truncate<int32_t>(x));
  } else {
    return narrow<To>(truncate<int32_t>(x));
  }
}

// Converts the element `x` to To.
template <class To, class From>
constexpr To convert(From x) noexcept {
  if constexpr (std::same_as<To, From>) {
    return x;
  } else if constexpr (std::same_as<From, float16>) {
    return convert<To>(static_cast<float>(x));
  } else if constexpr (std::same_as<To, float16>) {
    return float16(convert<float>(x));
  } else if constexpr (std::floating_point<To>) {
    return static_cast<To>(x);
  } else if constexpr (std::floating_point<From>) {
    return from_float<To>(x);
  } else if constexpr (sizeof(To) < sizeof(From)) {
    return narrow<To>(x);
  } else {
    return static_cast<To>(x);  // extends by the signedness of From
  }
}

// Converts an operand to an element: integers take the low bits of the integer part, like a C cast
// (-1.5 is 255 as a uint8, and 40000 remains 40000 as a uint16).
template <class To, class From>
constexpr To convert_operand(From x) noexcept {
  if constexpr (!std::integral<To>) {
    return convert<To>(x);
  } else if constexpr (std::integral<From>) {
    return static_cast<To>(x);
  } else {
    return static_cast<To>(truncate<int64_t>(x));
  }
}

// An integer type that holds sums and products of two T; 64-bit types wrap as unsigned.
template <std::integral T>
struct WideOf {
  using Signed = std::conditional_t<
      sizeof(T) == 1, int16_t,
      std::conditional_t<sizeof(T) == 2,
                         std::conditional_t<std::signed_integral<T>, int32_t, int64_t>, int64_t>>;
  // The square of the largest uint32 needs all 64 bits.
  using type = std::conditional_t<sizeof(T) == 4 && std::unsigned_integral<T>, uint64_t, Signed>;
};

// 8, 16 and 32 bits saturate, 64 bits wrap, float16 rounds each result.
template <class T>
constexpr T add(T x, T y) noexcept {
  if constexpr (std::same_as<T, float16>) {
    return float16(static_cast<float>(x) + static_cast<float>(y));
  } else if constexpr (std::floating_point<T>) {
    return x + y;
  } else if constexpr (sizeof(T) == 8) {
    return static_cast<T>(static_cast<uint64_t>(x) + static_cast<uint64_t>(y));
  } else {
    using Wide = typename WideOf<T>::type;
    return static_cast<T>(saturate<T>(static_cast<Wide>(Wide{x} + Wide{y})));
  }
}

template <class T>
constexpr T mul(T x, T y) noexcept {
  if constexpr (std::same_as<T, float16>) {
    return float16(static_cast<float>(x) * static_cast<float>(y));
  } else if constexpr (std::floating_point<T>) {
    return x * y;
  } else if constexpr (sizeof(T) == 8) {
    return static_cast<T>(static_cast<uint64_t>(x) * static_cast<uint64_t>(y));
  } else if constexpr (sizeof(T) == 1) {
    using Wide = std::conditional_t<std::signed_integral<T>, int16_t, uint16_t>;
    return static_cast<T>(saturate<T>(static_cast<Wide>(Wide{x} * Wide{y})));
  } else {
    using Wide = typename WideOf<T>::type;
    return static_cast<T>(saturate<T>(static_cast<Wide>(Wide{x} * Wide{y})));
  }
}

// C division, but an integer divided by 0 is unchanged, and the lowest one divided by -1 wraps to
// itself.
template <class T>
constexpr T div(T x, T y) noexcept {
  if constexpr (std::same_as<T, float16>) {
    return float16(static_cast<float>(x) / static_cast<float>(y));
  } else if constexpr (std::floating_point<T>) {
    return x / y;
  } else {
    if (y == 0) return x;
    if constexpr (std::signed_integral<T>) {
      using Unsigned = std::make_unsigned_t<T>;
      if (y == -1) return static_cast<T>(Unsigned{0} - static_cast<Unsigned>(x));
    }
    return static_cast<T>(x / y);
  }
}

}  // namespace weir::transform
