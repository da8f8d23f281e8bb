// Two plans in one pass give the same bits as one after the other, or are not fused.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/transform_test_support.hpp"

namespace weir::transform {
namespace fused_test {

struct Stage {
  Mode mode;
  const char* option;
};

std::vector<std::byte> applied(const TransformPlan& plan, const std::vector<std::byte>& in,
                               Counters* counters) {
  std::vector<std::byte> out(*plan.output().bytes());
  const auto counted = plan.apply(in, out);
  counters->divisions_by_zero += counted.divisions_by_zero;
  return out;
}

// Returns whether the two were fused; compares the results if they were.
bool fuses(const Stage& one, const Stage& two, const TensorSpec& spec, bool accelerate = true) {
  SCOPED_TRACE(std::string(one.option) + " then " + two.option + " of " + spec.to_string());
  const auto first = test::plan_of(one.mode, one.option, spec, accelerate);
  const auto second = test::plan_of(two.mode, two.option, first.output(), accelerate);
  const auto both = fused(first, second);
  if (!both) return false;
  EXPECT_EQ(both->input().type, first.input().type);
  EXPECT_EQ(both->output().type, second.output().type);
  std::mt19937_64 random(11);
  std::vector<std::byte> in(*spec.bytes());
  for (auto& byte : in) byte = static_cast<std::byte>(random());
  Counters apart, together;
  const auto expected = applied(second, applied(first, in, &apart), &apart);
  EXPECT_EQ(applied(*both, in, &together), expected);
  EXPECT_EQ(together.divisions_by_zero, apart.divisions_by_zero);
  if (both->in_place_possible()) {
    std::vector<std::byte> place = in;
    both->apply(place, place);
    EXPECT_EQ(place, expected);
  }
  return true;
}

constexpr Stage kCast{Mode::Typecast, "float32"};
constexpr Stage kScale{Mode::Arithmetic, "add:-127.5,mul:0.0078125"};
constexpr Stage kLimit{Mode::Clamp, "-0.5:0.5"};
constexpr Stage kBack{Mode::Typecast, "uint8"};
constexpr Stage kZeroDivision{Mode::Arithmetic, "div:0,add:3"};
constexpr Stage kChannels{Mode::Arithmetic, "per-channel:true@0,add:1@0,mul:3@2"};
constexpr Stage kPlanes{Mode::Arithmetic, "per-channel:true@2,add:1@0,mul:3@2"};
// Dimension 2 of these tensors has one channel: `@0` means all elements, `@1` none.
constexpr Stage kOnlyChannel{Mode::Arithmetic, "per-channel:true@2,add:5@0,mul:2@1"};
constexpr Stage kZeroOfAChannel{Mode::Arithmetic, "per-channel:true@0,div:0@1,add:1"};
constexpr Stage kCastAndScale{Mode::Arithmetic, "typecast:float32,add:-127.5,div:127.5"};
constexpr Stage kOrder{Mode::Transpose, "1:0:2:3"};
constexpr Stage kStand{Mode::Stand, "default"};

TEST(Fused, EqualsBothInSequence) {
  for (const uint32_t width : {1u, 7u, 2048u / 3, 5000u}) {
    const TensorSpec bytes{ElementType::UInt8, {3, width}, ""};
    const TensorSpec reals{ElementType::Float32, {3, width}, ""};
    for (const bool accelerate : {true, false}) {
      EXPECT_TRUE(fuses(kCast, kScale, bytes, accelerate));
      EXPECT_TRUE(fuses(kScale, kLimit, reals, accelerate));
      EXPECT_TRUE(fuses(kLimit, kBack, reals, accelerate));
      EXPECT_TRUE(fuses(kZeroDivision, kChannels, bytes, accelerate));
      EXPECT_TRUE(fuses(kChannels, kZeroDivision, bytes, accelerate));
      EXPECT_TRUE(fuses(kChannels, kChannels, bytes, accelerate));
      EXPECT_TRUE(fuses(kZeroOfAChannel, kScale, bytes, accelerate));
      EXPECT_TRUE(fuses(kScale, kZeroOfAChannel, bytes, accelerate));
    }
  }
}

TEST(Fused, AStepForTheOnlyChannelStaysOne) {
  for (const uint32_t width : {1u, 7u, 2048u / 3}) {
    const TensorSpec bytes{ElementType::UInt8, {3, width}, ""};
    for (const bool accelerate : {true, false}) {
      EXPECT_TRUE(fuses(kChannels, kOnlyChannel, bytes, accelerate));
      EXPECT_TRUE(fuses(kOnlyChannel, kChannels, bytes, accelerate));
    }
  }
}

TEST(Fused, ThreeAreFusedTwoByTwo) {
  const TensorSpec spec{ElementType::UInt8, {3, 1000}, ""};
  const auto cast = test::plan_of(Mode::Typecast, "float32", spec, true);
  const auto scale = test::plan_of(Mode::Arithmetic, kScale.option, cast.output(), true);
  const auto limit = test::plan_of(Mode::Clamp, kLimit.option, scale.output(), true);
  const auto both = fused(cast, scale);
  ASSERT_TRUE(both);
  const auto all = fused(*both, limit);
  ASSERT_TRUE(all);
  std::vector<std::byte> in(3000);
  for (size_t i = 0; i < in.size(); ++i) in[i] = static_cast<std::byte>(i);
  Counters counters;
  EXPECT_EQ(applied(*all, in, &counters),
            applied(limit, applied(scale, applied(cast, in, &counters), &counters), &counters));
}

TEST(Fused, ArithmeticAfterACastHandlesDistantChannels) {
  for (const bool accelerate : {true, false})
    for (const uint32_t width : {100u, 7u}) {
      const TensorSpec spec{ElementType::UInt8, {width, 100, 3}, ""};
      EXPECT_TRUE(fuses(kCast, kPlanes, spec, accelerate));
      EXPECT_TRUE(fuses(kPlanes, kScale, spec, accelerate));
      EXPECT_TRUE(fuses(kCastAndScale, kPlanes, spec, accelerate));
    }
}

TEST(Fused, ArithmeticAfterACastIsOneChain) {
  const TensorSpec spec{ElementType::UInt8, {3, 1000}, ""};
  const auto one = test::plan_of(kCastAndScale.mode, kCastAndScale.option, spec, true);
  const auto cast = test::plan_of(kCast.mode, kCast.option, spec, true);
  const auto both =
      fused(cast, test::plan_of(Mode::Arithmetic, "add:-127.5,div:127.5", cast.output(), true));
  ASSERT_TRUE(both);
  std::vector<std::byte> in(3000);
  for (size_t i = 0; i < in.size(); ++i) in[i] = static_cast<std::byte>(i);
  Counters counters;
  EXPECT_EQ(applied(*both, in, &counters), applied(one, in, &counters));
}

TEST(Fused, OneWithVectorsAndOneWithout) {
  const TensorSpec spec{ElementType::UInt8, {3, 1000}, ""};
  std::vector<std::byte> in(3000);
  for (size_t i = 0; i < in.size(); ++i) in[i] = static_cast<std::byte>(i * 7);
  for (const bool first : {true, false}) {
    const auto cast = test::plan_of(kCast.mode, kCast.option, spec, first);
    const auto scale = test::plan_of(kScale.mode, kScale.option, cast.output(), !first);
    const auto both = fused(cast, scale);
    ASSERT_TRUE(both);
    Counters counters;
    EXPECT_EQ(applied(*both, in, &counters),
              applied(scale, applied(cast, in, &counters), &counters));
  }
}

std::string random_steps(std::mt19937_64& random, const Shape& shape) {
  constexpr const char* kOperators[] = {"add:", "mul:", "div:"};
  constexpr const char* kOperands[] = {"0", "1", "-3", "7", "0.5", "-127.5", "58.4", "70000"};
  std::string option;
  const size_t dimension = random() % 3;
  const bool channels = random() % 2 == 0;
  if (channels) option += "per-channel:true@" + std::to_string(dimension) + ",";
  for (size_t i = 0, count = 1 + random() % 3; i < count; ++i) {
    option += (i > 0 ? "," : "") + std::string(kOperators[random() % 3]) + kOperands[random() % 8];
    if (channels && random() % 2 == 0)
      option += "@" + std::to_string(random() % (shape[dimension] + 1));
  }
  return option;
}

TEST(Fused, AnyTwoOptionsGiveTheSameBits) {
  std::mt19937_64 random(5);
  size_t one_pass = 0;
  for (int round = 0; round < 600; ++round) {
    const Shape shape{1 + static_cast<uint32_t>(random() % 4),
                      1 + static_cast<uint32_t>(random() % 300),
                      1 + static_cast<uint32_t>(random() % 3)};
    const auto from = static_cast<ElementType>(random() % 11);
    const auto to = std::string(to_string(static_cast<ElementType>(random() % 11)));
    const auto first = random_steps(random, shape), second = random_steps(random, shape);
    const Stage stages[] = {{Mode::Typecast, to.c_str()},
                            {Mode::Arithmetic, first.c_str()},
                            {Mode::Arithmetic, second.c_str()},
                            {Mode::Clamp, "-3:9"}};
    const size_t one = random() % 4, two = random() % 4;
    one_pass += fuses(stages[one], stages[two], {from, shape, ""}, round % 2 == 0);
  }
  EXPECT_GT(one_pass, 400u);
}

TEST(Fused, ElementWiseNeedsNoNeighbouringElements) {
  const TensorSpec spec{ElementType::UInt8, {3, 100, 100}, ""};
  for (const auto& stage : {kCast, kScale, kLimit, kChannels, kPlanes})
    EXPECT_TRUE(test::plan_of(stage.mode, stage.option, spec, true).is_element_wise())
        << stage.option;
  for (const auto& stage :
       {kOrder, kStand, Stage{Mode::Padding, "left:1"}, Stage{Mode::Dimchg, "0:1"}})
    EXPECT_FALSE(test::plan_of(stage.mode, stage.option, spec, true).is_element_wise())
        << stage.option;
}

TEST(Fused, NotIfAWholeTensorIsNeeded) {
  const TensorSpec spec{ElementType::UInt8, {3, 100, 100}, ""};
  EXPECT_FALSE(fuses(kCast, kOrder, spec));
  EXPECT_FALSE(fuses(kOrder, kCast, spec));
  EXPECT_FALSE(fuses(kStand, kCast, spec));
  EXPECT_FALSE(fuses(kPlanes, kLimit, {ElementType::UInt8, {100, 100, 3}, ""}))
      << "its channels come again after more than a block";
}

}  // namespace fused_test
}  // namespace weir::transform
