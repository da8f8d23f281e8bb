// Typecast: options, all 121 pairs of types, and reference values for saturating and wrapping
// pairs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/transform_test_support.hpp"

#include "says.hpp"

namespace weir::transform {
namespace typecast_test {

using test::for_each_target;
using test::run;

template <class From, class To>
void expect_as_reference(const std::vector<From>& in, const std::vector<To>& out) {
  for (size_t i = 0; i < in.size(); ++i) {
    const To expected = test::reference_cast<To>(test::value_of(in[i]), test::type_of<From>());
    ASSERT_TRUE(test::same(out[i], expected))
        << to_string(test::type_of<From>()) << " -> " << to_string(test::type_of<To>())
        << " element " << i << ": " << static_cast<double>(in[i]) << " gave "
        << static_cast<double>(out[i]) << ", needed " << static_cast<double>(expected);
  }
}

template <class From>
void check_all_targets_types(size_t count, bool accelerate) {
  std::mt19937_64 random(count);
  const auto in = test::random_values<From>(count, random);
  for (uint32_t i = 0; i < static_cast<uint32_t>(ElementType::End); ++i)
    visit_type(static_cast<ElementType>(i), [&](auto tag) {
      using To = typename decltype(tag)::type;
      const auto name = to_string(static_cast<ElementType>(i));
      const Shape shape{static_cast<uint32_t>(count)};
      expect_as_reference<From, To>(in, run<To>(Mode::Typecast, name, shape, in, accelerate));
    });
}

void check_all_pairs(size_t count, bool accelerate) {
  for (uint32_t i = 0; i < static_cast<uint32_t>(ElementType::End); ++i)
    visit_type(static_cast<ElementType>(i), [&](auto tag) {
      check_all_targets_types<typename decltype(tag)::type>(count, accelerate);
    });
}

TEST(Typecast, PlainPathFollowsTheTableForAllPairs) {
  check_all_pairs(3000, false);
}

TEST(Typecast, EveryTargetFollowsTheTableForAllPairs) {
  for_each_target([] { check_all_pairs(3000, true); });
}

TEST(Typecast, EveryTailLengthIsCorrect) {
  for_each_target([] {
    for (const size_t count : {1, 2, 3, 7, 8, 15, 16, 17, 63, 65, 255, 256, 257, 511, 513})
      check_all_pairs(count, true);
  });
}

template <class From, class To>
void golden(const std::vector<From>& in, const std::vector<To>& expected) {
  const auto name = std::string(to_string(test::type_of<To>()));
  const Shape shape{static_cast<uint32_t>(in.size())};
  for (const bool accelerate : {false, true})
    EXPECT_EQ((run<To>(Mode::Typecast, name, shape, in, accelerate)), expected)
        << to_string(test::type_of<From>()) << " -> " << name << " accelerate " << accelerate;
}

// Computed with NumPy: np.clip(np.int32(x), low, high).astype(to), or astype if the type wraps.
TEST(TypecastGolden, FloatToSmallIntegers) {
  const std::vector<float> in{-1.0f,    300.7f,    127.9f, -128.9f, -129.5f, 255.0f,
                              40000.0f, -40000.0f, 3e9f,   -3e9f,   1e20f};
  golden<float, uint8_t>(in, {255, 44, 127, 128, 127, 255, 64, 192, 255, 0, 255});
  golden<float, int8_t>(in, {-1, 127, 127, -128, -128, 127, 127, -128, 127, -128, 127});
  golden<float, int16_t>(in, {-1, 300, 127, -128, -129, 255, 32767, -32768, 32767, -32768, 32767});
  golden<float, uint16_t>(in,
                          {65535, 300, 127, 65408, 65407, 255, 32767, 32768, 32767, 32768, 32767});
}

TEST(TypecastGolden, FloatToLargeIntegers) {
  const std::vector<double> in{-1.9, 2147483647.5, 3e9, -3e9, 1e30, -1e30, 4294967296.0, 9e18};
  golden<double, int32_t>(
      in, {-1, INT32_MAX, INT32_MAX, INT32_MIN, INT32_MAX, INT32_MIN, INT32_MAX, INT32_MAX});
  golden<double, uint32_t>(in, {UINT32_MAX, 2147483647u, 2147483647u, 2147483648u, 2147483647u,
                                2147483648u, 2147483647u, 2147483647u});
  golden<double, int64_t>(in, {-1, 2147483647, 3000000000, -3000000000, INT64_MAX, INT64_MIN,
                               4294967296, 9000000000000000000});
  golden<double, uint64_t>(
      in, {UINT64_MAX, 2147483647, 3000000000, 18446744070709551616ull, 9223372036854775807ull,
           9223372036854775808ull, 4294967296, 9000000000000000000});
}

TEST(TypecastGolden, NotANumberIsTheLowest) {
  const std::vector<float> in{NAN, -NAN};
  golden<float, int32_t>(in, {INT32_MIN, INT32_MIN});
  golden<float, int16_t>(in, {INT16_MIN, INT16_MIN});
  golden<float, uint8_t>(in, {0, 0});
  golden<float, int64_t>(in, {INT64_MIN, INT64_MIN});
}

TEST(TypecastGolden, SixteenBitsToEight) {
  golden<int16_t, int8_t>({127, 128, -128, -129, 32767, -32768}, {127, 127, -128, -128, 127, -128});
  golden<uint16_t, int8_t>({127, 128, 32767, 32768, 65535}, {127, 127, 127, -128, -1});
  golden<int16_t, uint8_t>({255, 256, 300, -1, -32768}, {255, 0, 44, 255, 0});
  golden<uint16_t, uint8_t>({255, 256, 65535}, {255, 0, 255});
}

TEST(TypecastGolden, ThirtyTwoBitsToSixteenSaturateInTheSignedRange) {
  const std::vector<int32_t> in{32767, 32768, 40000, 65535, -1, -5, -32769, INT32_MAX, INT32_MIN};
  golden<int32_t, int16_t>(in, {32767, 32767, 32767, 32767, -1, -5, -32768, 32767, -32768});
  golden<int32_t, uint16_t>(in, {32767, 32767, 32767, 32767, 65535, 65531, 32768, 32767, 32768});
  golden<uint32_t, uint16_t>({40000, 4294967295u}, {32767, 65535});
  golden<uint32_t, int8_t>({200, 4294967295u, 2147483648u}, {127, -1, -128});
  golden<int32_t, uint8_t>({256, 257, -2}, {0, 1, 254});
}

TEST(TypecastGolden, SixtyFourBitsToFewer) {
  const std::vector<int64_t> in{3000000000, -3000000000, 70000, -70000, 200, INT64_MAX, INT64_MIN};
  golden<int64_t, int32_t>(in, {INT32_MAX, INT32_MIN, 70000, -70000, 200, INT32_MAX, INT32_MIN});
  golden<int64_t, uint32_t>(
      in, {2147483647u, 2147483648u, 70000, 4294897296u, 200, 2147483647u, 2147483648u});
  golden<int64_t, int16_t>(in, {32767, -32768, 32767, -32768, 200, 32767, -32768});
  golden<int64_t, uint16_t>(in, {32767, 32768, 32767, 32768, 200, 32767, 32768});
  golden<int64_t, int8_t>(in, {127, -128, 127, -128, 127, 127, -128});
  golden<int64_t, uint8_t>(in, {0, 0, 112, 144, 200, 255, 0});
  const std::vector<uint64_t> large{3000000000u, 70000, 200, UINT64_MAX};
  golden<uint64_t, int32_t>(large, {INT32_MAX, 70000, 200, INT32_MAX});
  golden<uint64_t, int16_t>(large, {32767, 32767, 200, 32767});
  golden<uint64_t, uint16_t>(large, {24064, 4464, 200, 65535});
  golden<uint64_t, int8_t>(large, {0, 112, -56, -1});
  golden<uint64_t, uint8_t>(large, {0, 112, 200, 255});
}

TEST(TypecastGolden, WideningExtendsByTheSourcesSign) {
  golden<int8_t, uint16_t>({-1, -128, 127}, {65535, 65408, 127});
  golden<uint8_t, int32_t>({255, 128}, {255, 128});
  golden<int8_t, uint64_t>({-1}, {UINT64_MAX});
  golden<uint32_t, int64_t>({UINT32_MAX}, {4294967295});
  golden<int8_t, uint8_t>({-1, -128}, {255, 128});
  golden<uint8_t, int8_t>({255, 200}, {-1, -56});
}

TEST(TypecastGolden, UnsignedAndWideIntegersKeepTheirValueAsFloats) {
  golden<uint32_t, float>({4294967295u, 2147483648u}, {4294967296.0f, 2147483648.0f});
  golden<uint32_t, double>({4294967295u}, {4294967295.0});
  golden<int64_t, double>({5000000000, -5000000000}, {5e9, -5e9});
  golden<uint64_t, float>({UINT64_MAX}, {18446744073709551616.0f});
}

TEST(Typecast, Float16GoesThroughFloat) {
  const auto halves = run<float16>(Mode::Typecast, "float16", Shape{4},
                                   std::vector<float>{1.0f, 65504.0f, 65520.0f, -0.0f});
  EXPECT_EQ(halves[0].bits, 0x3C00);
  EXPECT_EQ(halves[1].bits, 0x7BFF);
  EXPECT_EQ(halves[2].bits, 0x7C00);  // rounds to infinity
  EXPECT_EQ(halves[3].bits, 0x8000);
}

TEST(Typecast, OptionIsATypeNameInAnyCase) {
  for (const char* option : {"uint8", "FLOAT32", "Int64", "float16"}) {
    const auto operation = parse(Mode::Typecast, option);
    ASSERT_TRUE(operation) << option;
    EXPECT_EQ(std::get<Typecast>(operation->what).to, parse_element_type(option));
    EXPECT_EQ(operation->mode(), Mode::Typecast);
  }
}

TEST(Typecast, OtherOptionsAreRejectedWithTheNearestName) {
  for (const char* option : {"", " ", "uint 8", "uint8,", "uint88", "int", "float", "float3",
                             "double", "uint8:int8", "8", "uint128"}) {
    const auto operation = parse(Mode::Typecast, option);
    ASSERT_FALSE(operation) << option;
    EXPECT_EQ(operation.error().code, Code::OPTION_SYNTAX) << option;
    EXPECT_SAYS(operation.error().difference, *option ? "^" : "it is empty") << option;
  }
  EXPECT_EQ(parse(Mode::Typecast, "flaot32").error().fix, "option=float32");
  EXPECT_EQ(parse(Mode::Typecast, "uint88").error().fix, "option=uint8");
}

TEST(Typecast, SameTypeIsACopy) {
  const TensorSpec spec{ElementType::Float32, {3, 4}, ""};
  EXPECT_TRUE(test::plan_of(Mode::Typecast, "float32", spec, true).is_copy());
  EXPECT_FALSE(test::plan_of(Mode::Typecast, "int32", spec, true).is_copy());
  const std::vector<float> in{1, 2, 3};
  EXPECT_EQ((run<float>(Mode::Typecast, "float32", Shape{3}, in)), in);
}

}  // namespace typecast_test
}  // namespace weir::transform
