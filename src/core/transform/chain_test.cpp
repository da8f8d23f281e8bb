// Arithmetic: compares with a second version of the rules, on each SIMD target and without SIMD.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cinttypes>

#include "core/transform/transform_test_support.hpp"

namespace weir::transform {
namespace chain_test {

using test::for_each_target;
using test::run;

template <class To>
To typed_operand(const ArithmeticStep& step) {
  const auto* integer = std::get_if<int64_t>(&step.operand);
  const auto value =
      integer ? test::value_of(*integer) : test::value_of(std::get<double>(step.operand));
  if constexpr (std::is_integral_v<To>)
    return test::wrapped<To>(integer ? value.integer : test::whole_part(value.number, 64));
  else
    return test::reference_cast<To>(value, ElementType::Float64);
}

// Plain loops over all dimensions, innermost first.
template <class To, class From>
std::vector<To> reference(const Arithmetic& arithmetic, const Shape& shape,
                          const std::vector<From>& in, uint64_t& by_zero_count) {
  std::vector<To> out;
  std::vector<uint32_t> index(kRankLimit, 0);
  for (const From& value : in) {
    To x = test::reference_cast<To>(test::value_of(value), test::type_of<From>());
    for (const auto& step : arithmetic.steps) {
      const auto dimension = arithmetic.channel_dimension;
      if (dimension && step.channel && index[*dimension] != *step.channel) continue;
      bool by_zero = false;
      x = test::reference_apply<To>(step.op, x, typed_operand<To>(step), &by_zero);
      by_zero_count += by_zero;
    }
    out.push_back(x);
    for (size_t i = 0; i < kRankLimit && ++index[i] >= std::max(shape[i], 1u); ++i) index[i] = 0;
  }
  return out;
}

// On every target where it is accelerated.
template <class To, class From>
void expect_as_reference(const std::string& option, const Shape& shape, const std::vector<From>& in,
                         bool accelerate) {
  const auto operation = parse(Mode::Arithmetic, option);
  ASSERT_TRUE(operation) << option;
  uint64_t by_zero = 0;
  const auto expected = reference<To>(std::get<Arithmetic>(operation->what), shape, in, by_zero);
  const auto check = [&] {
    Counters counters;
    const auto out = run<To>(Mode::Arithmetic, option, shape, in, accelerate, &counters);
    for (size_t i = 0; i < in.size(); ++i)
      ASSERT_TRUE(test::same(out[i], expected[i]))
          << option << " on " << to_string(test::type_of<From>()) << " " << shape.to_string()
          << " element " << i << ": " << static_cast<double>(in[i]) << " gave "
          << static_cast<double>(out[i]) << ", needed " << static_cast<double>(expected[i])
          << " accelerate " << accelerate;
    EXPECT_EQ(counters.divisions_by_zero, by_zero) << option;
  };
  accelerate ? for_each_target(check) : check();
}

std::string random_number(std::mt19937_64& random) {
  constexpr const char* kNumbers[] = {"0",
                                      "1",
                                      "-1",
                                      "2",
                                      "-3",
                                      "7",
                                      "100",
                                      "127",
                                      "255",
                                      "300",
                                      "-129",
                                      "70000",
                                      "0.5",
                                      "-1.5",
                                      ".25",
                                      "1e3",
                                      "-2e-2",
                                      "127.5",
                                      "58.395",
                                      "-103.53",
                                      "3000000000",
                                      "-9000000000",
                                      "9223372036854775807",
                                      "1e20"};
  return kNumbers[random() % std::size(kNumbers)];
}

std::string random_option(std::mt19937_64& random, ElementType to, const Shape& shape) {
  std::string option;
  if (to != ElementType::End) option += "typecast:" + std::string(to_string(to)) + ",";
  const size_t dimension = random() % (shape.rank() + 1);
  const bool by_channel = random() % 2 == 0;
  if (by_channel) option += "per-channel:true@" + std::to_string(dimension) + ",";
  const size_t count = 1 + random() % 6;
  for (size_t i = 0; i < count; ++i) {
    constexpr const char* kNames[] = {"add:", "mul:", "div:"};
    option += (i > 0 ? "," : "") + std::string(kNames[random() % 3]) + random_number(random);
    if (random() % 3 != 0)
      option += "@" + std::to_string(random() % (std::max(shape[dimension], 1u) + 1));
  }
  return option;
}

Shape random_shape(std::mt19937_64& random) {
  const size_t rank = 1 + random() % 5;
  std::vector<uint32_t> dims(rank);
  for (auto& dim : dims) dim = 1 + random() % 5;
  const size_t grown = random() % rank;
  dims[grown] = 1 + static_cast<uint32_t>(random() % 300);
  return Shape(dims);
}

template <class From>
void check_random_option(std::mt19937_64& random, bool accelerate) {
  const auto shape = random_shape(random);
  const auto in = test::random_values<From>(*shape.count(), random);
  const auto to = static_cast<ElementType>(random() % 12);  // End: no typecast
  const auto option = random_option(random, to, shape);
  const auto out_type = to == ElementType::End ? test::type_of<From>() : to;
  visit_type(out_type, [&](auto tag) {
    expect_as_reference<typename decltype(tag)::type>(option, shape, in, accelerate);
  });
}

void check_random_options(size_t rounds, bool accelerate) {
  std::mt19937_64 random(rounds);
  for (size_t i = 0; i < rounds && !::testing::Test::HasFatalFailure(); ++i)
    visit_type(static_cast<ElementType>(random() % 11), [&](auto tag) {
      check_random_option<typename decltype(tag)::type>(random, accelerate);
    });
}

TEST(Arithmetic, PlainPathAgreesWithTheReference) {
  check_random_options(600, false);
}

TEST(Arithmetic, EveryTargetAgreesWithTheReference) {
  check_random_options(600, true);
}

// The whole input range, so that each reciprocal that replaces a division meets every value.
TEST(Arithmetic, DivisionsOfBytesAreExactForEveryValueAndTarget) {
  std::vector<uint8_t> in;
  for (size_t i = 0; i < 256 * 3; ++i) in.push_back(static_cast<uint8_t>(i / 3));
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(-200, 200);
  for (int round = 0; round < 200; ++round) {
    std::string option = "typecast:float32,per-channel:true@0";
    for (const char* channel : {"@0", "@1", "@2"})
      option += ",add:" + std::to_string(uniform(random)) + channel;
    for (const char* channel : {"@0", "@1", "@2"})
      option += ",div:" + std::to_string(uniform(random)) + channel;
    expect_as_reference<float>(option, Shape{3, 256}, in, true);
    option = "typecast:float32,add:" + std::to_string(uniform(random)) +
             ",div:" + std::to_string(uniform(random));
    expect_as_reference<float>(option, Shape{3, 256}, in, true);
  }
}

TEST(Arithmetic, ChannelsBeyondAnyVectorLengthAreCorrect) {
  std::mt19937_64 random(11);
  for (const auto& shape : {Shape{300, 3, 2}, Shape{17, 5, 3}, Shape{1, 3, 257}, Shape{1001, 2},
                            Shape{255, 2, 2}, Shape{256, 2, 2}, Shape{5, 1}}) {
    const auto in = test::random_values<uint8_t>(*shape.count(), random);
    for (const char* dim : {"0", "1", "2", "9"}) {
      const std::string option = "typecast:float32,per-channel:true@" + std::string(dim) +
                                 ",add:-1.5@0,mul:3@1,div:7@0,add:2,div:3@2";
      expect_as_reference<float>(option, shape, in, true);
    }
  }
}

TEST(Arithmetic, OperandsRepeatedAfterAnyNumberOfElementsAreCorrect) {
  std::mt19937_64 random(11);
  for (uint32_t channels : {1, 2, 3, 4, 5, 6, 8, 9, 12, 15, 16, 17, 24, 48, 200, 257}) {
    const Shape shape{channels, 1200 / channels + 7};  // several groups of vectors and a rest
    const auto bytes = test::random_values<uint8_t>(*shape.count(), random);
    const auto floats = test::random_values<float>(*shape.count(), random);
    std::string option = "per-channel:true@0,add:1.5";
    for (const uint32_t channel : {0U, channels / 2, channels - 1})
      for (const char* step : {",add:-123.675@", ",div:58.395@", ",mul:0.3@"})
        option += step + std::to_string(channel);
    for_each_target([&] {
      expect_as_reference<float>("typecast:float32," + option, shape, bytes, true);
      expect_as_reference<float>(option, shape, floats, true);
    });
  }
}

TEST(Arithmetic, ManyChannelsBeyondTheTableAreCorrect) {
  const Shape shape{2, 200000};
  std::mt19937_64 random(3);
  const auto in = test::random_values<int16_t>(*shape.count(), random);
  expect_as_reference<int16_t>("per-channel:true@1,add:5@199999,mul:2@0,div:3@7", shape, in, true);
}

TEST(Arithmetic, OperandsAreConvertedToTheTensorsTypeFirst) {
  const std::vector<uint8_t> in{0, 1, 100, 255};
  for (const bool accelerate : {false, true}) {
    EXPECT_EQ((run<uint8_t>(Mode::Arithmetic, "mul:0.5", Shape{4}, in, accelerate)),
              (std::vector<uint8_t>{0, 0, 0, 0}));
    EXPECT_EQ((run<uint8_t>(Mode::Arithmetic, "add:-1.5", Shape{4}, in, accelerate)),
              (std::vector<uint8_t>{255, 255, 255, 255}));
    EXPECT_EQ((run<uint8_t>(Mode::Arithmetic, "add:1.9", Shape{4}, in, accelerate)),
              (std::vector<uint8_t>{1, 2, 101, 255}));
  }
}

TEST(Arithmetic, SmallIntegersSaturateAndWideOnesWrap) {
  EXPECT_EQ((run<int8_t>(Mode::Arithmetic, "add:100,add:-100", Shape{3},
                         std::vector<int8_t>{100, 0, -100})),
            (std::vector<int8_t>{27, 0, -100}));
  EXPECT_EQ((run<int32_t>(Mode::Arithmetic, "mul:2", Shape{3},
                          std::vector<int32_t>{2000000000, -2000000000, 3})),
            (std::vector<int32_t>{INT32_MAX, INT32_MIN, 6}));
  EXPECT_EQ((run<uint32_t>(Mode::Arithmetic, "mul:4294967295", Shape{2},
                           std::vector<uint32_t>{4294967295u, 1})),
            (std::vector<uint32_t>{4294967295u, 4294967295u}));
  EXPECT_EQ(
      (run<uint16_t>(Mode::Arithmetic, "add:40000", Shape{2}, std::vector<uint16_t>{1, 30000})),
      (std::vector<uint16_t>{40001, 65535}));
  EXPECT_EQ((run<int64_t>(Mode::Arithmetic, "add:1", Shape{1}, std::vector<int64_t>{INT64_MAX})),
            (std::vector<int64_t>{INT64_MIN}));
  EXPECT_EQ((run<int64_t>(Mode::Arithmetic, "add:5000000000,mul:3", Shape{1},
                          std::vector<int64_t>{6000000000})),
            (std::vector<int64_t>{33000000000}));  // exceeds 32 bits
}

TEST(Arithmetic, IntegerDivisionByZeroKeepsTheElementAndIsCounted) {
  const std::vector<int32_t> in{7, -7, 0, 9, 5, 6};
  for (const bool accelerate : {false, true}) {
    Counters counters;
    EXPECT_EQ((run<int32_t>(Mode::Arithmetic, "div:0,add:1", Shape{6}, in, accelerate, &counters)),
              (std::vector<int32_t>{8, -6, 1, 10, 6, 7}));
    EXPECT_EQ(counters.divisions_by_zero, 6u);
    EXPECT_EQ((run<int32_t>(Mode::Arithmetic, "per-channel:true@0,div:0.9@1,div:2@0", Shape{3, 2},
                            in, accelerate, &counters)),
              (std::vector<int32_t>{3, -7, 0, 4, 5, 6}));
    EXPECT_EQ(counters.divisions_by_zero, 2u);
  }
}

TEST(Arithmetic, LowestIntegerByMinusOneWraps) {
  for (const bool accelerate : {false, true}) {
    EXPECT_EQ((run<int32_t>(Mode::Arithmetic, "div:-1", Shape{2},
                            std::vector<int32_t>{INT32_MIN, 5}, accelerate)),
              (std::vector<int32_t>{INT32_MIN, -5}));
    EXPECT_EQ((run<int64_t>(Mode::Arithmetic, "div:-1", Shape{1}, std::vector<int64_t>{INT64_MIN},
                            accelerate)),
              (std::vector<int64_t>{INT64_MIN}));
  }
}

TEST(Arithmetic, FloatDivisionByZeroIsInfinityAndNotCounted) {
  Counters counters;
  const auto out = run<float>(Mode::Arithmetic, "div:0", Shape{3}, std::vector<float>{1, -1, 0},
                              true, &counters);
  EXPECT_EQ(out[0], INFINITY);
  EXPECT_EQ(out[1], -INFINITY);
  EXPECT_TRUE(std::isnan(out[2]));
  EXPECT_EQ(counters.divisions_by_zero, 0u);
}

TEST(Arithmetic, ChannelsWithoutPerChannelAreIgnored) {
  const std::vector<uint8_t> in{1, 2, 3};
  for (const char* option : {"add:5@1", "per-channel:false,add:5@1"})
    EXPECT_EQ((run<uint8_t>(Mode::Arithmetic, option, Shape{3}, in)),
              (std::vector<uint8_t>{6, 7, 8}));
}

TEST(Arithmetic, UntouchedChannelsKeepMinusZero) {
  const auto out = run<float>(Mode::Arithmetic, "per-channel:true@0,add:1@0,mul:2@0,div:3@0",
                              Shape{2}, std::vector<float>{0.5f, -0.0f});
  EXPECT_EQ(out[0], 1.0f);
  EXPECT_TRUE(std::signbit(out[1]));
}

TEST(Arithmetic, InPlaceGivesTheSameResults) {
  std::mt19937_64 random(5);
  for (const size_t count : {1, 255, 256, 1000}) {
    auto values = test::random_values<float>(count, random);
    const TensorSpec spec{ElementType::Float32, {static_cast<uint32_t>(count)}, ""};
    for (const char* option : {"add:1.5,mul:3", "typecast:int32,add:3,div:2"}) {
      const auto made = test::plan_of(Mode::Arithmetic, option, spec, true);
      ASSERT_TRUE(made.in_place_possible());
      std::vector<float> apart(count);
      made.apply(test::bytes_of(values), std::as_writable_bytes(std::span(apart)));
      auto in_place = values;
      made.apply(test::bytes_of(in_place), std::as_writable_bytes(std::span(in_place)));
      EXPECT_EQ(std::memcmp(apart.data(), in_place.data(), count * 4), 0) << option;
    }
  }
}

// Tensors that exceed the caches use non-temporal stores.
TEST(Arithmetic, LargeTensorsAreTheSameAtAnyPlace) {
  constexpr size_t kCount = 3 * 1400 * 1003;
  const TensorSpec spec{ElementType::UInt8, {3, 1400, 1003}, ""};
  const char* option = "typecast:float32,per-channel:true@0,add:-7@0,add:3@1,div:58.5@2";
  std::vector<uint8_t> in(kCount);
  for (size_t i = 0; i < kCount; ++i) in[i] = static_cast<uint8_t>(i * 2654435761U >> 13);
  std::vector<float> store(kCount + 32);
  void* start = store.data();
  size_t room = store.size() * sizeof(float);
  auto* aligned = static_cast<float*>(std::align(64, kCount * sizeof(float), start, room));
  for_each_target([&] {
    const auto plan = test::plan_of(Mode::Arithmetic, option, spec, true);
    for (float* const out : {aligned, aligned + 1}) {
      plan.apply(test::bytes_of(in), std::as_writable_bytes(std::span(out, kCount)));
      for (size_t i = 0; i < kCount; ++i) {
        const auto x = static_cast<float>(in[i]);
        ASSERT_EQ(out[i], i % 3 == 0 ? x - 7 : i % 3 == 1 ? x + 3 : x / 58.5f) << i;
      }
    }
  });
}

TEST(Arithmetic, DifferentElementSizesAreNotDoneInPlace) {
  const TensorSpec spec{ElementType::UInt8, {10}, ""};
  EXPECT_FALSE(
      test::plan_of(Mode::Arithmetic, "typecast:float32,add:1", spec, true).in_place_possible());
}

// Guards at odd addresses before and after the spans stay untouched.
TEST(Arithmetic, ShortAndUnalignedSpansAreRespected) {
  const TensorSpec spec{ElementType::UInt8, {1000}, ""};
  std::vector<std::byte> in(1001, std::byte{9});
  for (const char* option : {"typecast:float32,add:1", "typecast:float64,add:1"})
    for (const bool accelerate : {false, true}) {
      const auto made = test::plan_of(Mode::Arithmetic, option, spec, accelerate);
      const size_t size = element_size(made.output().type);
      for (const size_t elements : {size_t{0}, size_t{1}, size_t{63}, size_t{999}, size_t{1000}}) {
        std::vector<std::byte> out(elements * size + 20, std::byte{0xEE});
        made.apply(std::span(in).subspan(1), std::span(out).subspan(1, elements * size + size - 1));
        const size_t written = elements * size;
        EXPECT_EQ(out[0], std::byte{0xEE});
        for (size_t i = written + 1; i < out.size(); ++i) ASSERT_EQ(out[i], std::byte{0xEE});
        if (elements > 0) {
          EXPECT_NE(out[written], std::byte{0xEE});
        }
      }
    }
}

TEST(Arithmetic, ShortInputCountsOnlyPresentElements) {
  const TensorSpec spec{ElementType::UInt8, {3, 4}, ""};
  const auto made = test::plan_of(Mode::Arithmetic, "per-channel:true@0,div:0@1", spec, true);
  std::vector<std::byte> in(5), out(12);
  EXPECT_EQ(made.apply(in, out).divisions_by_zero, 2u);  // elements 1 and 4
  EXPECT_EQ(made.apply({}, out).divisions_by_zero, 0u);
}

TEST(Arithmetic, PlansCanBeCopiedAndUsedTogether) {
  const TensorSpec spec{ElementType::UInt8, {3}, ""};
  const auto made = test::plan_of(Mode::Arithmetic, "add:1", spec, true);
  const TransformPlan copy = made;
  const std::vector<uint8_t> in{1, 2, 3};
  std::vector<uint8_t> a(3), b(3);
  made.apply(test::bytes_of(in), std::as_writable_bytes(std::span(a)));
  copy.apply(test::bytes_of(in), std::as_writable_bytes(std::span(b)));
  EXPECT_EQ(a, b);
}

}  // namespace chain_test
}  // namespace weir::transform
