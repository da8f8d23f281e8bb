// Compares decisions with a plain comparison in the element's own type.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/condition/comparison.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "says.hpp"

namespace weir::condition {
namespace comparison_test {

constexpr Operator kOperators[] = {
    Operator::Equal,      Operator::NotEqual,       Operator::Greater, Operator::GreaterOrEqual,
    Operator::Less,       Operator::LessOrEqual,    Operator::InRange, Operator::InsideRange,
    Operator::NotInRange, Operator::NotInsideRange,
};

// The table of docs/compatibility/routing.md 6.7, in C.
template <class T>
bool expected(int op, T x, T a, T b) {
  const bool table[] = {x == a, x != a,           x > a,          x >= a,         x < a,
                        x <= a, a <= x && x <= b, a < x && x < b, x < a || b < x, x <= a || b <= x};
  return table[op];
}

template <class T>
std::vector<std::byte> bytes_of(const std::vector<T>& values) {
  std::vector<std::byte> out(values.size() * sizeof(T));
  std::memcpy(out.data(), values.data(), out.size());
  return out;
}

bool decide(ElementType type, const std::vector<std::byte>& element, int op,
            const std::string& supplied) {
  const auto condition =
      parse_condition(ComparedValue::Element, "0,0", static_cast<Operator>(op), supplied);
  EXPECT_TRUE(condition) << supplied;
  const auto comparison = Comparison::make(*condition, {{type, Shape{1}, ""}});
  EXPECT_TRUE(comparison);
  return comparison->holds(element);
}

template <class T>
struct TypeOf;
#define TYPE(cpp, name)                                     \
  template <>                                               \
  struct TypeOf<cpp> {                                      \
    static constexpr ElementType kType = ElementType::name; \
  };
TYPE(int8_t, Int8)
TYPE(uint8_t, UInt8)
TYPE(int16_t, Int16)
TYPE(uint16_t, UInt16)
TYPE(int32_t, Int32)
TYPE(uint32_t, UInt32)
TYPE(int64_t, Int64)
TYPE(uint64_t, UInt64)
TYPE(float, Float32)
TYPE(double, Float64)

template <class T>
class ComparisonOf : public testing::Test {};
using Types = testing::Types<int8_t, uint8_t, int16_t, uint16_t, int32_t, uint32_t, int64_t,
                             uint64_t, float, double>;
TYPED_TEST_SUITE(ComparisonOf, Types);

TYPED_TEST(ComparisonOf, WholeNumbersBecomeTheTypeAsCCastsThem) {
  using T = TypeParam;
  const int64_t numbers[] = {0,    1,      -1,         5,          100,      127,       128,
                             255,  256,    300,        32768,      65535,    65536,     2147483648,
                             -128, -32769, 4294967295, 4294967296, 16777217, INT64_MAX, INT64_MIN};
  for (int op = 0; op < 10; ++op)
    for (const int64_t a : numbers)
      for (const int64_t b : {a, a + (a < INT64_MAX ? 1 : 0), int64_t{100}})
        for (const int64_t element : {a, b, int64_t{7}}) {
          const T x = static_cast<T>(element);
          EXPECT_EQ(decide(TypeOf<T>::kType, bytes_of(std::vector<T>{x}), op,
                           std::to_string(a) + "," + std::to_string(b)),
                    expected<T>(op, x, static_cast<T>(a), static_cast<T>(b)))
              << "operator " << op << ", " << element << " against " << a << ", " << b;
        }
}

TYPED_TEST(ComparisonOf, RealNumbersAreTruncatedToTheTypeFirst) {
  using T = TypeParam;
  for (int op = 0; op < 10; ++op)
    for (const double a : {0.0, 1.5, 1.999, 2.0, 99.25, 100.5})
      for (const double b : {a, a + 1, a + 0.75})
        for (const T x : {static_cast<T>(0), static_cast<T>(1), static_cast<T>(2),
                          static_cast<T>(99), static_cast<T>(100.5), static_cast<T>(101)})
          EXPECT_EQ(decide(TypeOf<T>::kType, bytes_of(std::vector<T>{x}), op,
                           std::to_string(a) + "," + std::to_string(b)),
                    expected<T>(op, x, static_cast<T>(a), static_cast<T>(b)))
              << "operator " << op << ", " << +x << " against " << a << ", " << b;
}

TYPED_TEST(ComparisonOf, AveragesAreFloat64TruncatedToTheType) {
  using T = TypeParam;
  std::mt19937 random(11);
  for (const size_t count : {1u, 2u, 7u, 8u, 9u, 100u, 4097u}) {
    std::vector<T> values(count);
    double sum = 0;  // integers, so exact in any order
    for (T& value : values) {
      value = static_cast<T>(random() % 120);
      sum += static_cast<double>(value);
    }
    const double mean = sum / static_cast<double>(count);
    EXPECT_EQ(average(TypeOf<T>::kType, bytes_of(values)), mean);
    for (int op = 0; op < 10; ++op) {
      const auto condition =
          parse_condition(ComparedValue::Average, "1", static_cast<Operator>(op), "59.5,60.5");
      const auto comparison = Comparison::make(
          *condition, {{ElementType::UInt8, Shape{1}, ""},
                       {TypeOf<T>::kType, Shape{static_cast<uint32_t>(count)}, ""}});
      ASSERT_TRUE(comparison);
      EXPECT_EQ(comparison->tensor(), 1u);
      EXPECT_EQ(comparison->bytes(), count * sizeof(T));
      EXPECT_EQ(comparison->holds(bytes_of(values)),
                expected<T>(op, static_cast<T>(mean), static_cast<T>(59.5), static_cast<T>(60.5)));
    }
  }
}

TEST(Comparison, AveragesOfManyLargeNumbersAreExact) {
  constexpr size_t kCount = 100001;
  EXPECT_EQ(average(ElementType::UInt8, bytes_of(std::vector<uint8_t>(kCount, 255))), 255);
  EXPECT_EQ(average(ElementType::UInt16, bytes_of(std::vector<uint16_t>(kCount, 65535))), 65535);
  EXPECT_EQ(average(ElementType::Int16, bytes_of(std::vector<int16_t>(kCount, -32768))), -32768);
  EXPECT_EQ(average(ElementType::Int32, bytes_of(std::vector<int32_t>(kCount, INT32_MIN))),
            INT32_MIN);
  EXPECT_EQ(average(ElementType::UInt32, bytes_of(std::vector<uint32_t>(kCount, UINT32_MAX))),
            UINT32_MAX);
}

TEST(Comparison, RoundsSuppliedValuesToFloat16) {
  const auto holds = [](float element, Operator op, const char* supplied) {
    return decide(ElementType::Float16, bytes_of(std::vector<float16>{float16(element)}),
                  static_cast<int>(op), supplied);
  };
  EXPECT_TRUE(holds(0.0999755859375f, Operator::Equal, "0.1")) << "the float16 next to 0.1";
  EXPECT_TRUE(holds(2048, Operator::Equal, "2049")) << "2049 has no float16, even is 2048";
  EXPECT_FALSE(holds(2050, Operator::Equal, "2049"));
  EXPECT_TRUE(holds(65504, Operator::Less, "70000")) << "infinity";
  EXPECT_TRUE(holds(1.5f, Operator::InsideRange, "1,2"));
  EXPECT_FALSE(holds(2, Operator::InsideRange, "1,2"));
  EXPECT_TRUE(holds(2, Operator::NotInsideRange, "1,2"));
  EXPECT_TRUE(holds(-0.0f, Operator::Equal, "0"));
  const std::vector<float16> values{float16(1), float16(2), float16(4.5f)};
  EXPECT_EQ(average(ElementType::Float16, bytes_of(values)), 2.5);
}

TEST(Comparison, NotInRangeMeansBelowOrAbove) {
  for (const int x : {1, 10, 15, 20, 30}) {
    const auto bytes = bytes_of(std::vector<int32_t>{x});
    const auto holds = [&](Operator op) {
      return decide(ElementType::Int32, bytes, static_cast<int>(op), "10,20");
    };
    EXPECT_EQ(holds(Operator::NotInRange), x == 1 || x == 30);
    EXPECT_EQ(holds(Operator::NotInsideRange), x != 15);
    EXPECT_EQ(holds(Operator::InRange), x >= 10 && x <= 20);
    EXPECT_EQ(holds(Operator::InsideRange), x == 15);
  }
}

TEST(Comparison, NaNEqualsNothingAndIsInAndOutOfNoRange) {
  const auto nan = bytes_of(std::vector<float>{std::numeric_limits<float>::quiet_NaN()});
  for (const Operator op : kOperators)
    EXPECT_EQ(decide(ElementType::Float32, nan, static_cast<int>(op), "1,2"),
              op == Operator::NotEqual);
}

TEST(Comparison, OfValuesBeyondInt64) {
  const auto max = bytes_of(std::vector<uint64_t>{UINT64_MAX});
  EXPECT_TRUE(decide(ElementType::UInt64, max, 0, "-1")) << "as C casts it";
  EXPECT_TRUE(decide(ElementType::UInt64, max, 0, "1e20")) << "the nearest there is";
  const auto high = bytes_of(std::vector<uint64_t>{10000000000000000000u});
  EXPECT_TRUE(decide(ElementType::UInt64, high, 0, "1e19"));
  EXPECT_TRUE(decide(ElementType::UInt8, bytes_of(std::vector<uint8_t>{44}), 0, "300"));
}

TEST(Comparison, FindsTheElementByItsCoordinate) {
  std::mt19937 random(3);
  for (int round = 0; round < 200; ++round) {
    TensorSpec spec{ElementType::UInt16, {}, ""};
    const size_t rank = 1 + random() % 16;
    std::string text;
    size_t index = 0, step = 1;
    for (size_t d = 0; d < rank; ++d) {
      spec.shape[d] = 1 + static_cast<uint32_t>(random() % (rank > 6 ? 2 : 5));
      const auto at = random() % spec.shape[d];
      text += (d ? ":" : "") + std::to_string(at);
      index += at * step;
      step *= spec.shape[d];
    }
    const auto condition =
        parse_condition(ComparedValue::Element, text + ",0", Operator::Equal, "1");
    const auto comparison = Comparison::make(*condition, {spec});
    ASSERT_TRUE(comparison) << comparison.error().message();
    EXPECT_EQ(comparison->offset(), 2 * index);
    EXPECT_EQ(comparison->bytes(), 2u);
  }
}

std::string refused(ComparedValue compared, const char* option) {
  const auto condition = parse_condition(compared, option, Operator::Equal, "1");
  const auto comparison = Comparison::make(*condition, {{ElementType::UInt8, Shape{3, 4}, ""}});
  EXPECT_FALSE(comparison);
  return comparison ? "" : comparison.error().message();
}

TEST(Comparison, RejectsElementsThatTheStreamLacks) {
  const auto text = refused(ComparedValue::Element, "0:4,0");
  EXPECT_SAYS(text, "WEIR-1004: compared-value-option names an element that does not exist");
  EXPECT_SAYS(text, "offered: coordinate 4 in dimension 1");
  EXPECT_SAYS(text, "needed: below 4");
  EXPECT_SAYS(text, "tensor 0 is uint8 3:4");
  EXPECT_SAYS(refused(ComparedValue::Element, "0:0:1,0"), "coordinate 1 in dimension 2");
  EXPECT_SAYS(refused(ComparedValue::Element, "0,1"), "index 1");
  EXPECT_SAYS(refused(ComparedValue::Element, "0,1"), "fix: compared-value-option=0:0:0:0,0");
  EXPECT_SAYS(refused(ComparedValue::Average, "9"), "there are 1 tensors");
}

}  // namespace comparison_test
}  // namespace weir::condition
