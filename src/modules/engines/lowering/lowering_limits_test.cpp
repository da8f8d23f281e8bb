// Tests of models with values at the limits of their types; under UndefinedBehaviorSanitizer no sum
// and no product may overflow.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <limits>
#include <map>

#include "lowering/lowering.hpp"
#include "says.hpp"
#include "tensorflow-lite/tflite_builder_test_support.hpp"

namespace weir::engine_test {
namespace lowering_limits_test {

constexpr int64_t kMax64 = std::numeric_limits<int64_t>::max();
constexpr int64_t kMin64 = std::numeric_limits<int64_t>::min();
constexpr int32_t kMax32 = std::numeric_limits<int32_t>::max();
constexpr int32_t kMin32 = std::numeric_limits<int32_t>::min();

enum : int32_t {
  kAveragePool = 1,
  kConvolution = 3,
  kDepthwise = 4,
  kMaxPool = 17,
  kPad = 34,
  kGather = 36,
  kStridedSlice = 45,
  kArgMax = 56,
  kTransposed = 67,
  kPack = 83,
  kUnpack = 88
};

Error get_error(const TfliteBuilder& model) {
  const auto bytes = model.bytes();
  const auto lowered = engine::lower_tflite(bytes);
  return lowered ? Error{.code = Code::INTERNAL, .what = "it is lowered"} : lowered.error();
}

TfliteBuilder with_input(const std::vector<int32_t>& shape) {
  TfliteBuilder model;
  model.input("x", kTfInt8, shape).quantized({{0.5f}, {1}});
  return model;
}
TfliteBuilder& with_output(TfliteBuilder& model, const std::vector<int32_t>& shape) {
  return model.output("y", kTfInt8, shape).quantized({{0.5f}, {1}});
}

TEST(LoweringLimits, PaddingWhoseSumOverflowsIsRejected) {
  for (const std::vector<int64_t>& pads :
       {std::vector<int64_t>{kMax64, kMax64}, {kMax64, 1}, {1, kMax64}, {kMin64, kMax64}}) {
    auto model = with_input({2});
    model.constant<int64_t>("p", kTfInt64, {1, 2}, pads);
    with_output(model, {0}).node(kPad, {"x", "p"}, {"y"});
    const Error error = get_error(model);
    EXPECT_EQ(error.code, Code::MODEL_UNSUPPORTED);
    EXPECT_SAYS(error.message(), "padding that does not give the output's shape");
  }
}

TEST(LoweringLimits, ZeroPointsOfWeightsAreRejected) {
  for (const int64_t zero : {kMax64, kMax64 - 127, kMin64, int64_t{-129}, int64_t{128}}) {
    auto model = with_input({1, 2});
    model.constant<int8_t>("w", kTfInt8, {1, 2}, {1, 2}).quantized({{0.5f}, {zero}});
    with_output(model, {1, 1}).node(kOpFullyConnected, {"x", "w", ""}, {"y"});
    EXPECT_SAYS(get_error(model).message(),
                "zero points of weights that differ or are out of range")
        << zero;
  }
}

TEST(LoweringLimits, ZeroPointsOfTensorsAreRejected) {
  for (const int64_t zero : {kMax64, kMin64}) {
    TfliteBuilder model;
    model.input("x", kTfInt8, {2}).quantized({{0.5f}, {zero}});
    with_output(model, {2}).node(kOpReshape, {"x"}, {"y"});
    EXPECT_SAYS(get_error(model).message(), "a zero point is out of range") << zero;
  }
}

// Sets each field of an operator's options to the limits of int32, with the others at 1.
TEST(LoweringLimits, OptionsAtTheEndsOfTheirTypeAreRejectedOrLowered) {
  struct Case {
    int32_t op;
    uint8_t options;
    uint32_t first, last;  // fields of type int32
    bool weights;
  };
  constexpr Case kCases[] = {{kConvolution, 1, 1, 5, true},  {kDepthwise, 2, 1, 6, true},
                             {kAveragePool, 5, 1, 4, false}, {kMaxPool, 5, 1, 4, false},
                             {kGather, 23, 0, 1, false},     {kPack, 59, 0, 1, false},
                             {kUnpack, 64, 0, 1, false},     {kOpConcatenation, 10, 0, 0, false}};
  for (const Case& tried : kCases)
    for (const int32_t extreme : {kMax32, kMin32})
      for (uint32_t at = tried.first; at <= tried.last; ++at) {
        std::map<uint32_t, FlatValue> fields;
        for (uint32_t field = tried.first; field <= tried.last; ++field)
          fields[field] = FlatValue::scalar<int32_t>(field == at ? extreme : 1);
        auto model = with_input({1, 4, 4, 1});
        model.constant<int8_t>("w", kTfInt8, {1, 2, 2, 1}, {1, 2, 3, 4}).quantized({{0.5f}, {0}});
        std::vector<std::string> inputs{"x"};
        if (tried.weights) inputs.insert(inputs.end(), {"w", ""});
        with_output(model, {1, 3, 3, 1}).node(tried.op, inputs, {"y"});
        model.options(tried.options, FlatValue::table(fields));
        EXPECT_FALSE(get_error(model).what.empty()) << tried.op << ' ' << at;
      }
}

TEST(LoweringLimits, SlicesAtTheEndsOfTheirTypeAreRejectedOrLowered) {
  for (const int64_t begin : {kMin64, int64_t{0}, kMax64})
    for (const int64_t end : {kMin64, kMax64})
      for (const int64_t step : {int64_t{1}, kMax64}) {
        auto model = with_input({5});
        for (const auto& [name, value] : {std::pair{"b", begin}, {"e", end}, {"s", step}})
          model.constant<int64_t>(name, kTfInt64, {1}, {value});
        with_output(model, {5}).node(kStridedSlice, {"x", "b", "e", "s"}, {"y"});
        EXPECT_FALSE(get_error(model).what.empty());
      }
}

TEST(LoweringLimits, AnAxisAtTheEndsOfItsTypeIsRejected) {
  for (const int64_t axis : {kMin64, kMax64}) {
    auto model = with_input({5});
    model.constant<int64_t>("a", kTfInt64, {1}, {axis})
        .output("y", kTfInt64, {1})
        .node(kArgMax, {"x", "a"}, {"y"});
    EXPECT_SAYS(get_error(model).message(), "an axis that does not exist");
  }
}

// With one extent of 0, any other extent fits into the file.
TEST(LoweringLimits, ExtentsOfAnEmptyTensorAreRejected) {
  auto model = with_input({0, kMax32, kMax32, kMax32});
  model.constant<int8_t>("w", kTfInt8, {1, 2, 2, 1}, {1, 2, 3, 4}).quantized({{0.5f}, {0}});
  with_output(model, {0, kMax32, kMax32, kMax32});
  for (const int32_t op :
       {int32_t{kConvolution}, int32_t{kDepthwise}, int32_t{kMaxPool}, int32_t{kAveragePool},
        int32_t{kOpReshape}, int32_t{kOpFullyConnected}}) {
    auto tried = model;
    tried.node(op, {"x", "w"}, {"y"});
    EXPECT_EQ(get_error(tried).code, Code::MODEL_UNSUPPORTED) << op;
  }
}

}  // namespace lowering_limits_test
}  // namespace weir::engine_test
