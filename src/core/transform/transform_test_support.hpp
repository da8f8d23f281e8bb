// For the tests of the transform: typed runs of a plan, each SIMD target, and the number rules
// written a second time, over 128-bit integers, as the table of
// docs/compatibility/transform.md 3.11 reads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "core/transform/transform.hpp"

namespace weir::transform::test {

__extension__ using Int128 = __int128;
__extension__ using UInt128 = unsigned __int128;

// Calls f once per SIMD target of this CPU; failures name the target.
template <class F>
void for_each_target(F&& f) {
  for (const auto target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    SCOPED_TRACE(hwy::TargetName(target));
    f();
  }
  hwy::SetSupportedTargetsForTest(0);
}

template <class T>
ElementType type_of() {
  for (uint32_t i = 0; i < static_cast<uint32_t>(ElementType::End); ++i) {
    const auto type = static_cast<ElementType>(i);
    if (visit_type(type, [](auto tag) { return std::same_as<typename decltype(tag)::type, T>; }))
      return type;
  }
  return ElementType::End;
}

inline TransformPlan plan_of(Mode mode, std::string_view option, const TensorSpec& in,
                             bool accelerate) {
  auto operation = parse(mode, option);
  EXPECT_TRUE(operation) << option << ": " << operation.error().message();
  auto result = plan(*operation, in, accelerate);
  EXPECT_TRUE(result) << result.error().message();
  return *std::move(result);
}

template <class T>
std::span<const std::byte> bytes_of(const std::vector<T>& values) {
  return std::as_bytes(std::span(values));
}

template <class To, class From>
std::vector<To> run(Mode mode, std::string_view option, const Shape& shape,
                    const std::vector<From>& in, bool accelerate = true,
                    Counters* counters = nullptr) {
  const auto made = plan_of(mode, option, {type_of<From>(), shape, ""}, accelerate);
  EXPECT_EQ(made.output().type, type_of<To>());
  std::vector<To> out(in.size());
  const auto counted = made.apply(bytes_of(in), std::as_writable_bytes(std::span(out)));
  if (counters != nullptr) *counters = counted;
  return out;
}

// ---- The number rules, second version -----------------------------------------------------------

// A number of any element type: an integer, or a double that represents it exactly.
struct Value {
  bool real = false;
  Int128 integer = 0;
  double number = 0;
};

template <class T>
Value value_of(T x) {
  if constexpr (std::is_integral_v<T>)
    return {false, x, 0};
  else
    return {true, 0,
            static_cast<double>(
                static_cast<std::conditional_t<std::is_same_v<T, float16>, float, T>>(x))};
}

inline Int128 clip(Int128 x, int bits) {
  const Int128 end = Int128{1} << (bits - 1);
  return x < -end ? -end : x >= end ? end - 1 : x;
}

// The low bits of x as a T.
template <class T>
T wrapped(Int128 x) {
  return static_cast<T>(static_cast<uint64_t>(x));
}

inline Int128 whole_part(double x, int bits) {
  const Int128 end = Int128{1} << (bits - 1);
  if (std::isnan(x)) return -end;
  if (x >= std::ldexp(1.0, bits - 1)) return end - 1;
  if (x < -std::ldexp(1.0, bits - 1)) return -end;
  return static_cast<Int128>(x);
}

template <class To>
To reference_narrow(Int128 x, ElementType from) {
  constexpr int kBits = sizeof(To) * 8;
  if (std::is_same_v<To, uint8_t>) return wrapped<To>(x);
  if (from == ElementType::UInt16) x = static_cast<int16_t>(x);
  if (from == ElementType::UInt32) x = static_cast<int32_t>(x);
  const bool truncates = std::is_same_v<To, int8_t> || std::is_same_v<To, uint16_t>;
  if (from == ElementType::UInt64 && truncates) return wrapped<To>(x);
  return wrapped<To>(clip(x, kBits));
}

template <class To>
To reference_cast(Value x, ElementType from) {
  if constexpr (std::is_same_v<To, float16>) {
    return float16(x.real ? static_cast<float>(x.number) : static_cast<float>(x.integer));
  } else if constexpr (std::is_floating_point_v<To>) {
    return x.real ? static_cast<To>(x.number) : static_cast<To>(x.integer);
  } else {
    if (x.real && sizeof(To) == 8) return wrapped<To>(whole_part(x.number, 64));
    if (x.real) {
      x.integer = whole_part(x.number, 32);
      from = ElementType::Int32;
    }
    if (sizeof(To) < element_size(from)) return reference_narrow<To>(x.integer, from);
    return wrapped<To>(x.integer);
  }
}

template <class To>
To reference_apply(Operator op, To x, To y, bool* by_zero) {
  if constexpr (std::is_integral_v<To>) {
    const Int128 a = x, b = y;
    const bool divides = op == Operator::Div;
    if (divides && b == 0) *by_zero = true;
    if (divides && b == 0) return x;
    if (divides) return wrapped<To>(a / b);
    // Unsigned, because the product of two 64-bit numbers can overflow; its low half is correct
    // anyway.
    const Int128 product = static_cast<Int128>(static_cast<UInt128>(a) * static_cast<UInt128>(b));
    const Int128 result = op == Operator::Add ? a + b : product;
    if (sizeof(To) == 8) return wrapped<To>(result);
    const Int128 low = std::numeric_limits<To>::min(), high = std::numeric_limits<To>::max();
    return static_cast<To>(result < low ? low : result > high ? high : result);
  } else {
    using Real = std::conditional_t<std::is_same_v<To, float16>, float, To>;
    volatile Real a = static_cast<Real>(x);  // volatile: each operation rounds separately
    const volatile Real b = static_cast<Real>(y);
    if (op == Operator::Add) a = a + b;
    if (op == Operator::Mul) a = a * b;
    if (op == Operator::Div) a = a / b;
    return To(static_cast<Real>(a));
  }
}

// Compares the bits; all NaNs are equal.
template <class T>
bool same(T a, T b) {
  if constexpr (!std::is_integral_v<T>)
    if (std::isnan(static_cast<double>(value_of(a).number)) &&
        std::isnan(static_cast<double>(value_of(b).number)))
      return true;
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

// Random bits, often an edge case.
template <class T>
T random_value(std::mt19937_64& random) {
  const auto bits = random();
  if constexpr (std::is_integral_v<T>) {
    using Limits = std::numeric_limits<T>;
    switch (bits % 8) {
      case 0:
        return Limits::max();
      case 1:
        return Limits::min();
      case 2:
        return static_cast<T>((bits >> 32) % 300);
      case 3:
        return static_cast<T>(T{0} - static_cast<T>((bits >> 32) % 300));
      default:
        return static_cast<T>(random() >> (bits % 3 * 16));
    }
  } else {
    const double edges[] = {0.0,   -0.0,     1.0,          -1.0,    127.9,    -129.2,
                            255.5, 300.7,    32768.0,      65535.0, -65536.0, 2147483647.0,
                            3e9,   -3e9,     2147483648.0, 9.3e18,  -9.3e18,  1e30,
                            -1e30, INFINITY, -INFINITY,    NAN,     6e-8,     1e-42};
    using Real = std::conditional_t<std::is_same_v<T, float16>, float, T>;
    if (bits % 3 == 0) return T(static_cast<Real>(edges[(bits >> 8) % std::size(edges)]));
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    return T(static_cast<Real>(std::ldexp(uniform(random), static_cast<int>((bits >> 8) % 40))));
  }
}

template <class T>
std::vector<T> random_values(size_t count, std::mt19937_64& random) {
  std::vector<T> values(count);
  for (auto& value : values) value = random_value<T>(random);
  return values;
}

}  // namespace weir::transform::test
