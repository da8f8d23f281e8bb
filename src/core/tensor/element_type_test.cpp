// Element types: names, sizes, and float16 against its definition.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/tensor/element_type.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace weir {
namespace element_type_test {

TEST(ElementType, HasTheNumbersAndSizesOfTheWireFormat) {
  EXPECT_EQ(static_cast<int>(ElementType::UInt8), 5);
  EXPECT_EQ(static_cast<int>(ElementType::Float16), 10);
  EXPECT_EQ(element_size(ElementType::Float64), 8u);
  EXPECT_EQ(element_size(ElementType::Float16), 2u);
  EXPECT_EQ(element_size(ElementType::End), 0u);
}

TEST(ElementType, ReadsNamesWithoutCaseAndBlanks) {
  EXPECT_EQ(parse_element_type(" UInt8 "), ElementType::UInt8);
  for (const char* text : {"", "uint", "uint12", "float8", "uint8x", "u int8", "double"})
    EXPECT_EQ(parse_element_type(text), ElementType::End) << text;
}

TEST(ElementType, VisitsTheTypeOfTheSameSize) {
  for (uint32_t i = 0; i < 11; ++i) {
    const auto type = static_cast<ElementType>(i);
    const size_t size = visit_type(type, []<class T>(std::type_identity<T>) { return sizeof(T); });
    EXPECT_EQ(size, element_size(type));
    EXPECT_EQ(parse_element_type(to_string(type)), type);
  }
}

// value = (-1)^s 2^(e-15) (1 + m/1024), or 2^-14 (m/1024) for e = 0.
float by_definition(uint16_t bits) {
  const int e = (bits >> 10) & 31;
  const float m = static_cast<float>(bits & 1023) / 1024.f;
  const float magnitude = e == 0 ? std::ldexp(m, -14) : std::ldexp(1.f + m, e - 15);
  return bits & 0x8000 ? -magnitude : magnitude;
}

TEST(Float16, EveryFiniteValueIsExactAndComesBack) {
  for (uint32_t bits = 0; bits < 0x10000; ++bits) {
    if (((bits >> 10) & 31) == 31) continue;
    float16 half;
    half.bits = static_cast<uint16_t>(bits);
    const float value = half;
    ASSERT_EQ(value, by_definition(half.bits));
    ASSERT_EQ(float16(value).bits, bits);
  }
}

TEST(Float16, RoundsToNearestEven) {
  EXPECT_EQ(static_cast<float>(float16(2049.f)), 2048.f);
  EXPECT_EQ(static_cast<float>(float16(2051.f)), 2052.f);
  EXPECT_EQ(static_cast<float>(float16(65519.f)), 65504.f);
  EXPECT_TRUE(std::isinf(static_cast<float>(float16(65520.f))));
  EXPECT_EQ(static_cast<float>(float16(0x1p-25f)), 0.f);
  EXPECT_EQ(static_cast<float>(float16(0x1.8p-25f)), 0x1p-24f);
}

TEST(Float16, KeepsInfinityAndNaN) {
  EXPECT_TRUE(std::isinf(static_cast<float>(float16(-std::numeric_limits<float>::infinity()))));
  EXPECT_TRUE(std::isnan(static_cast<float>(float16(std::nanf("")))));
}

}  // namespace element_type_test
}  // namespace weir
