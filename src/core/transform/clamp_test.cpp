// mode=clamp: its grammar, and every type against comparisons in long double, which holds all
// values.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/transform_test_support.hpp"

#include "says.hpp"

namespace weir::transform {
namespace clamp_test {

using test::for_each_target;
using test::type_of;

template <class T>
class ClampTypes : public testing::Test {};
using AllTypes = testing::Types<int8_t, uint8_t, int16_t, uint16_t, int32_t, uint32_t, int64_t,
                                uint64_t, float16, float, double>;
TYPED_TEST_SUITE(ClampTypes, AllTypes);

template <class T>
long double exact(T x) {
  if constexpr (std::is_same_v<T, float16>)
    return static_cast<float>(x);
  else
    return static_cast<long double>(x);
}

// The value of T nearest to a limit; for integers its integer part.
template <class T>
T nearest_value(double limit) {
  if constexpr (std::is_same_v<T, float16>) {
    return float16(static_cast<float>(limit));
  } else if constexpr (std::is_floating_point_v<T>) {
    return static_cast<T>(limit);
  } else {
    const long double whole = std::trunc(static_cast<long double>(limit));
    if (whole <= exact(std::numeric_limits<T>::min())) return std::numeric_limits<T>::min();
    if (whole >= exact(std::numeric_limits<T>::max())) return std::numeric_limits<T>::max();
    return static_cast<T>(whole);
  }
}

template <class T>
T reference(T x, double low, double high) {
  if (exact(x) < low) return nearest_value<T>(low);
  if (exact(x) > high) return nearest_value<T>(high);
  return x;
}

constexpr std::pair<double, double> kRanges[] = {
    {-1, 1},         {0, 255},      {0.5, 10.5}, {-0.5, 0.5},
    {-3.25, -3.25},  {-1e30, 1e30}, {300, 400},  {-9000, -8000},
    {1e19, 2e19},    {-1e-8, 1e-8}, {0.1, 0.3},  {4294967295.5, 9.3e18},
    {-129.5, 127.5}, {0, 65504.1}};

TYPED_TEST(ClampTypes, AreLimitedLikeTheReference) {
  std::mt19937_64 random(7);
  for (const auto& [low, high] : kRanges) {
    char option[64];
    std::snprintf(option, sizeof(option), "%.17g:%.17g", low, high);
    SCOPED_TRACE(option);
    for (const size_t count : {1, 255, 256, 1000}) {
      const auto in = test::random_values<TypeParam>(count, random);
      for_each_target([&] {
        const auto out =
            test::run<TypeParam>(Mode::Clamp, option, Shape{static_cast<uint32_t>(count)}, in);
        for (size_t i = 0; i < count; ++i)
          ASSERT_TRUE(test::same(out[i], reference(in[i], low, high)))
              << static_cast<double>(exact(in[i])) << " -> " << static_cast<double>(exact(out[i]));
      });
      EXPECT_EQ(
          test::run<TypeParam>(Mode::Clamp, option, Shape{static_cast<uint32_t>(count)}, in, false)
              .size(),
          count);
    }
  }
}

TYPED_TEST(ClampTypes, WorkInPlaceAtAnyAlignment) {
  std::mt19937_64 random(8);
  const auto in = test::random_values<TypeParam>(700, random);
  const auto plan = test::plan_of(Mode::Clamp, "-2.5:90", {type_of<TypeParam>(), {700}, ""}, true);
  ASSERT_TRUE(plan.in_place_possible());
  std::vector<std::byte> memory(700 * sizeof(TypeParam) + 1);
  const auto place = std::span(memory).subspan(1);
  std::memcpy(place.data(), in.data(), place.size());
  plan.apply(place, place);
  for (size_t i = 0; i < in.size(); ++i) {
    TypeParam out;
    std::memcpy(static_cast<void*>(&out), place.data() + i * sizeof(out), sizeof(out));
    ASSERT_TRUE(test::same(out, reference(in[i], -2.5, 90)));
  }
}

TEST(Clamp, KeepsTheSpec) {
  const auto plan = test::plan_of(Mode::Clamp, "0:1", {ElementType::Int16, {3, 4}, "name"}, true);
  EXPECT_EQ(plan.output().type, ElementType::Int16);
  EXPECT_EQ(plan.output().shape, (Shape{3, 4}));
  const auto operation = parse(Mode::Clamp, "0:1");
  EXPECT_EQ(input_candidates(*operation, {ElementType::Int16, {}})->type, ElementType::Int16);
}

TEST(Clamp, RejectsWhatItCannotRead) {
  struct Case {
    const char *option, *needed, *caret;
  };
  for (const auto& [option, needed, caret] :
       std::initializer_list<Case>{{"", "a number", "it is empty"},
                                   {"a:1", "a number", "character 1"},
                                   {"1", "':' and the highest value", "at the end"},
                                   {"0:x", "a number", "character 3"},
                                   {"0:1:2", "the end", "character 4"},
                                   {"0:1e999", "a float64", "character 3"},
                                   {"5:-1", "the lower limit first", "character 3"}}) {
    const auto operation = parse(Mode::Clamp, option);
    ASSERT_FALSE(operation) << option;
    EXPECT_SAYS(operation.error().needed, needed) << option;
    EXPECT_SAYS(operation.error().difference, caret);
  }
  EXPECT_EQ(parse(Mode::Clamp, "5:-1").error().fix, "option=-1:5");
}

}  // namespace clamp_test
}  // namespace weir::transform
