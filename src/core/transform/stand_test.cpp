// mode=stand: grammar, and results against the running average of
// docs/compatibility/transform.md 3.6, element by element.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/transform_test_support.hpp"

#include "says.hpp"

namespace weir::transform {
namespace stand_test {

using test::for_each_target;

template <class T>
double number(T x) {
  if constexpr (std::is_same_v<T, float16>)
    return static_cast<double>(static_cast<float>(x));
  else
    return static_cast<double>(x);
}

// Computes in double with the formulas of docs/compatibility/transform.md 3.6.
template <class T>
std::vector<double> reference(const std::vector<T>& in, size_t channels, bool divides) {
  std::vector<double> out(in.size());
  for (size_t channel = 0; channel < channels; ++channel) {
    double average = 0, squares = 0, n = 0;
    for (size_t i = channel; i < in.size(); i += channels)
      average += (number(in[i]) - average) / ++n;
    for (size_t i = channel; i < in.size(); i += channels)
      squares += (number(in[i]) - average) * (number(in[i]) - average) / n;
    const double deviation = squares == 0 ? 1e-10 : std::sqrt(squares);
    for (size_t i = channel; i < in.size(); i += channels)
      out[i] = divides ? std::abs(number(in[i]) - average) / deviation : number(in[i]) - average;
  }
  return out;
}

template <class T>
class StandTypes : public testing::Test {};
using AllTypes = testing::Types<int8_t, uint8_t, int16_t, uint16_t, int32_t, uint32_t, int64_t,
                                uint64_t, float16, float, double>;
TYPED_TEST_SUITE(StandTypes, AllTypes);

template <class T>
std::vector<T> moderate_values(size_t count, std::mt19937_64& random) {
  std::vector<T> out;
  for (size_t i = 0; i < count; ++i) {
    if constexpr (std::is_integral_v<T>)
      out.push_back(static_cast<T>(random() % 120));
    else
      out.push_back(T(static_cast<float>(random() % 2000) / 64.0f - 10.0f));
  }
  return out;
}

TYPED_TEST(StandTypes, AreStandardisedLikeTheReference) {
  std::mt19937_64 random(5);
  const Shape shapes[] = {{1}, {3, 1}, {3, 50}, {1, 999}, {255, 3}, {256, 4}, {300, 5}, {700, 2}};
  for (const auto& shape : shapes) {
    const auto in = moderate_values<TypeParam>(*shape.count(), random);
    for (const bool per_channel : {false, true}) {
      for (const bool divides : {false, true}) {
        const std::string option = std::string(divides ? "default" : "dc-average") + ":float64" +
                                   (per_channel ? ",per-channel:true" : "");
        SCOPED_TRACE(option + " of " + shape.to_string());
        const auto expected = reference(in, per_channel ? shape[0] : 1, divides);
        std::vector<double> first;
        for_each_target([&] {
          const auto out = test::run<double>(Mode::Stand, option, shape, in);
          for (size_t i = 0; i < in.size(); ++i)
            ASSERT_NEAR(out[i], expected[i], 1e-9 * std::max(1.0, std::abs(expected[i]))) << i;
          if (first.empty()) first = out;
          ASSERT_EQ(out, first) << "every target gives the same bits";
        });
        EXPECT_EQ(test::run<double>(Mode::Stand, option, shape, in, false), first);
      }
    }
  }
}

// All values of 8 and 16 bits, whose sums and tables have their own code paths; float32 near a mean
// that is large compared to the deviation.
template <class T>
std::vector<T> wide_values(size_t count, std::mt19937_64& random) {
  std::vector<T> out;
  for (size_t i = 0; i < count; ++i) {
    if constexpr (std::is_integral_v<T>)
      out.push_back(static_cast<T>(random()));
    else
      out.push_back(static_cast<T>(1e6 + static_cast<double>(random() % 1000) / 16));
  }
  return out;
}

template <class T>
class StandFewTypes : public testing::Test {};
using FewTypes = testing::Types<int8_t, uint8_t, int16_t, uint16_t, float>;
TYPED_TEST_SUITE(StandFewTypes, FewTypes);

// Long enough for several blocks of the sums, the table, and each layout of the channels.
const Shape kLong[] = {{1, 70001}, {2, 20001}, {3, 9001}, {4, 8001}, {5, 3001}, {16, 3001}};

// Checks each `result`; all targets and the scalar path must agree.
template <class To, class From, class Check>
void check_long(bool divides, const char* type, Check&& check) {
  std::mt19937_64 random(7);
  for (const auto& shape : kLong) {
    const auto in = wide_values<From>(*shape.count(), random);
    for (const bool per_channel : {false, true}) {
      const std::string option = std::string(divides ? "default:" : "dc-average:") + type +
                                 (per_channel ? ",per-channel:true" : "");
      SCOPED_TRACE(option + " of " + shape.to_string());
      const auto expected = reference(in, per_channel ? shape[0] : 1, divides);
      const auto plain = test::run<To>(Mode::Stand, option, shape, in, false);
      for (size_t i = 0; i < in.size(); ++i) ASSERT_NO_FATAL_FAILURE(check(plain[i], expected[i]));
      for_each_target([&] { ASSERT_EQ(test::run<To>(Mode::Stand, option, shape, in), plain); });
    }
  }
}

TYPED_TEST(StandFewTypes, ToFloat32AreWithinFourUnitsOfTheLastPlace) {
  for (const bool divides : {false, true})
    check_long<float, TypeParam>(divides, "float32", [](float result, double expected) {
      // 1e-7: the error of a mean of 1e6 in double, relevant for a distance near 0.
      ASSERT_NEAR(static_cast<double>(result), expected, std::abs(expected) * 0x1p-22 + 1e-7);
    });
}

TYPED_TEST(StandFewTypes, ToWholeNumbersAreThoseOfTheReference) {
  check_long<int32_t, TypeParam>(true, "int32", [](int32_t result, double expected) {
    // A quotient that is an integer up to the last bit may fall on either side.
    const double nearest = std::round(expected);
    if (std::abs(expected - nearest) < 1e-9)
      ASSERT_NEAR(result, nearest, 1);
    else
      ASSERT_EQ(result, static_cast<int32_t>(expected));
  });
}

TYPED_TEST(StandFewTypes, ToBytesAreThoseOfTheReference) {
  for (const bool divides : {false, true})
    check_long<uint8_t, TypeParam>(divides, "uint8", [](uint8_t result, double expected) {
      if (std::abs(expected - std::round(expected)) < 1e-6) return;
      ASSERT_EQ(result, static_cast<uint8_t>(static_cast<int32_t>(expected)));
    });
}

TEST(Stand, OfBytesWithOneOutlierGivesItsDistance) {
  std::vector<uint8_t> in(65536, 0);
  in[40000] = 255;  // mean 255 / 65536, so the quotient is sqrt(65535): 255.998
  const auto out = test::run<uint8_t>(Mode::Stand, "default", Shape{65536}, in);
  EXPECT_EQ(out[40000], 255);
  EXPECT_EQ(out[0], 0);
}

// More than the 32-bit lanes of the byte sums can hold at once.
TEST(Stand, OfMillionsOfTheLargestBytesHasNoSumThatOverflows) {
  constexpr size_t kCount = 3 * 1048576 + 77;
  std::vector<uint8_t> bytes(kCount, 255);
  for (size_t i = 0; i < kCount; i += 4) bytes[i] = 0;
  std::vector<int8_t> turned(kCount);
  for (size_t i = 0; i < kCount; ++i) turned[i] = static_cast<int8_t>(bytes[i] ^ 0x80);
  const double zeros = (kCount + 3) / 4, part = zeros / kCount;
  const double low = std::sqrt((1 - part) / part), high = std::sqrt(part / (1 - part));
  for_each_target([&] {
    const auto a = test::run<double>(Mode::Stand, "default:float64", Shape{kCount}, bytes);
    const auto b = test::run<double>(Mode::Stand, "default:float64", Shape{kCount}, turned);
    for (size_t i : {size_t{0}, size_t{1}, size_t{4}, kCount - 1}) {
      EXPECT_NEAR(a[i], i % 4 == 0 ? low : high, 1e-9) << i;
      EXPECT_NEAR(b[i], i % 4 == 0 ? low : high, 1e-9) << i;
    }
  });
}

TEST(Stand, KeepsTheDigitsOfFloatsFarFromZero) {
  std::vector<float> in(30000);
  for (size_t i = 0; i < in.size(); ++i) in[i] = 16777000.0f + static_cast<float>(i % 2 * 2);
  for (const float x : test::run<float>(Mode::Stand, "default", Shape{30000}, in))
    ASSERT_EQ(x, 1.0f);
  EXPECT_EQ(test::run<float>(Mode::Stand, "dc-average", Shape{30000}, in)[0], -1.0f);
}

TEST(Stand, OfFloatsNearTheEndOfTheirRangeDoesNotOverflow) {
  const std::vector<float> in{3e38f, -3e38f, 3e38f, -3e38f};
  EXPECT_EQ(test::run<float>(Mode::Stand, "default", Shape{4}, in),
            (std::vector<float>{1, 1, 1, 1}));
  const std::vector<float> tiny{1e-44f, -1e-44f, 1e-44f, -1e-44f};
  EXPECT_EQ(test::run<float>(Mode::Stand, "default", Shape{4}, tiny),
            (std::vector<float>{1, 1, 1, 1}));
}

TEST(Stand, SubtractsTheMean) {
  const std::vector<int16_t> in{1, 2, 3, 6};
  EXPECT_EQ(test::run<int16_t>(Mode::Stand, "dc-average", Shape{4}, in),
            (std::vector<int16_t>{-2, -1, 0, 3}));
  EXPECT_EQ(test::run<float>(Mode::Stand, "DC-Average:float32,per-channel:true", Shape{2, 2}, in),
            (std::vector<float>{-1, -2, 1, 2}));
}

TEST(Stand, DividesDistancesByTheDeviation) {
  const std::vector<float> in{2, 4, 4, 4, 5, 5, 7, 9};  // mean 5, deviation 2
  EXPECT_EQ(test::run<float>(Mode::Stand, "default", Shape{8}, in),
            (std::vector<float>{1.5, 0.5, 0.5, 0.5, 0, 0, 1, 2}));
  EXPECT_EQ(test::run<uint8_t>(Mode::Stand, "default:uint8,per-channel:false", Shape{8}, in),
            (std::vector<uint8_t>{1, 0, 0, 0, 0, 0, 1, 2}));
}

TEST(Stand, OfEqualElementsIsZero) {
  EXPECT_EQ(test::run<float>(Mode::Stand, "default", Shape{5}, std::vector<float>(5, 3.5f)),
            std::vector<float>(5, 0.0f));
  EXPECT_EQ(test::run<float>(Mode::Stand, "default", Shape{9999}, std::vector<float>(9999, 0.1f)),
            std::vector<float>(9999, 0.0f));
  EXPECT_EQ(test::run<uint8_t>(Mode::Stand, "default", Shape{9999}, std::vector<uint8_t>(9999, 3)),
            std::vector<uint8_t>(9999, 0));
}

// Tensors that exceed the caches use non-temporal stores.
TEST(Stand, LargeTensorsAreTheSameAtAnyPlace) {
  constexpr size_t kPixels = 1400 * 1003, kCount = 3 * kPixels;
  const TensorSpec spec{ElementType::UInt8, {3, 1400, 1003}, ""};
  std::vector<uint8_t> in(kCount);  // each channel has both values equally often
  for (size_t i = 0; i < kCount; ++i)
    in[i] = static_cast<uint8_t>(100 * (i % 3) + (i / 3 < kPixels / 2 ? 10 : 30));
  std::vector<float> store(kCount + 32);
  void* start = store.data();
  size_t room = store.size() * sizeof(float);
  auto* aligned = static_cast<float*>(std::align(64, kCount * sizeof(float), start, room));
  for_each_target([&] {
    const auto plan = test::plan_of(Mode::Stand, "dc-average:float32,per-channel:true", spec, true);
    for (float* const out : {aligned, aligned + 1}) {
      plan.apply(test::bytes_of(in), std::as_writable_bytes(std::span(out, kCount)));
      for (size_t i = 0; i < kCount; ++i)
        ASSERT_EQ(out[i], i / 3 < kPixels / 2 ? -10.0f : 10.0f) << i;
    }
  });
}

TEST(Stand, PassesNotANumberOn) {
  std::vector<float> in(10, 1.0f);
  in[4] = NAN;
  for (const float x : test::run<float>(Mode::Stand, "default", Shape{10}, in))
    EXPECT_TRUE(std::isnan(x));
}

TEST(Stand, WorksInPlaceWhereTheSizeStays) {
  const std::vector<float> expected{1.5, 0.5, 0.5, 0.5, 0, 0, 1, 2};
  std::vector<float> in{2, 4, 4, 4, 5, 5, 7, 9};
  const auto plan = test::plan_of(Mode::Stand, "default", {ElementType::Float32, {8}, ""}, true);
  ASSERT_TRUE(plan.in_place_possible());
  const auto bytes = std::as_writable_bytes(std::span(in));
  plan.apply(bytes, bytes);
  EXPECT_EQ(in, expected);
  EXPECT_FALSE(test::plan_of(Mode::Stand, "default:float32", {ElementType::UInt8, {8}, ""}, true)
                   .in_place_possible());
}

TEST(Stand, ReportsItsTypesForCaps) {
  const auto kept = parse(Mode::Stand, "default"), made = parse(Mode::Stand, "default:float32");
  EXPECT_EQ(input_candidates(*kept, {ElementType::Int8, {3}})->type, ElementType::Int8);
  EXPECT_TRUE(input_candidates(*made, {ElementType::Float32, {3}})->type_open());
  EXPECT_FALSE(input_candidates(*made, {ElementType::Int8, {3}}));
  EXPECT_EQ(output_candidates(*made, {ElementType::Int8, {3}}).type, ElementType::Float32);
}

TEST(Stand, RejectsWhatItCannotRead) {
  for (const auto& [option, needed] : std::initializer_list<std::pair<const char*, const char*>>{
           {"", "default or dc-average"},
           {"mean", "default or dc-average"},
           {"default:", "an element type"},
           {"default:flot32", "an element type"},
           {"default,per-channel:yes", "true or false"},
           {"default,per-channel:true@0", "or the end"},
           {"dc-average:float32x", "or the end"}}) {
    const auto operation = parse(Mode::Stand, option);
    ASSERT_FALSE(operation) << option;
    EXPECT_SAYS(operation.error().needed, needed) << option << ": " << operation.error().needed;
  }
}

}  // namespace stand_test
}  // namespace weir::transform
