// Tests of operators that gather and join values, of casts, and of values without quantisation: the
// lowered graph equals TensorFlow Lite, and unsupported operators are rejected.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <limits>

#include "lowering/lowering_test_support.hpp"
#include "says.hpp"

namespace weir::engine_test {
namespace unquantised_operators_test {

// Values of BuiltinOperator and BuiltinOptions.
enum : int32_t {
  kMultiply = 18,
  kBilinear = 23,
  kGather = 36,
  kDivide = 42,
  kArgMax = 56,
  kSquareRoot = 75,
  kPack = 83,
  kUnpack = 88,
  kFloorDivide = 90,
  kGatherNd = 107
};
enum : uint8_t {
  kConcatenationOptions = 10,
  kAddOptions = 11,
  kBilinearOptions = 15,
  kMultiplyOptions = 21,
  kGatherOptions = 23,
  kSubOptions = 28,
  kDivOptions = 29,
  kArgMaxOptions = 40,
  kPackOptions = 59,
  kUnpackOptions = 64
};
constexpr int8_t kRelu = 1, kRelu6 = 3;

FlatValue number(int32_t value) {
  return FlatValue::scalar(value);
}

class LoweredPlainOperators : public LoweringTest {
 protected:
  // Expects both to give the same bytes, and returns them.
  std::vector<TestTensor> same(const TfliteBuilder& model, const std::vector<TestTensor>& inputs) {
    const auto path = folder_.write("model.tflite", model.bytes());
    const auto own = opened(path), other = lowered(path);
    if (!own || !other) return {};
    const auto expected = own->invoke(inputs), found = other->invoke(inputs);
    if (!expected || !found) {
      ADD_FAILURE() << (expected ? found : expected).error().message();
      return {};
    }
    EXPECT_EQ(expected->size(), found->size());
    for (size_t i = 0; i < std::min(found->size(), expected->size()); ++i) {
      EXPECT_EQ(to_string((*expected)[i].info), to_string((*found)[i].info)) << i;
      EXPECT_EQ((*expected)[i].bytes, (*found)[i].bytes) << i;
    }
    return *found;
  }
  std::string refused(const TfliteBuilder& model) {
    take_log();
    (void)open(model.bytes(), kLowered);
    return logged();
  }
};

TestTensor floats(const std::vector<float>& values) {
  return make_tensor<float>(WEIR_FLOAT32, {static_cast<int64_t>(values.size())}, values);
}
TestTensor int32_tensor(const std::vector<int32_t>& values) {
  return make_tensor<int32_t>(WEIR_INT32, {static_cast<int64_t>(values.size())}, values);
}

TfliteBuilder cast(int8_t from, int8_t to, int32_t count) {
  return TfliteBuilder()
      .input("x", from, {count})
      .output("y", to, {count})
      .node(kOpCast, {"x"}, {"y"});
}

TEST_F(LoweredPlainOperators, CastsGoTowardsZero) {
  const auto given = floats({0, 0.5f, 0.99f, 1.5f, 2.5f, 126.7f, -0.9f, -1.5f, -127.9f});
  EXPECT_EQ(same(cast(kTfFloat, kTfInt32, 9), {given})[0].values<int32_t>(),
            (std::vector<int32_t>{0, 0, 0, 1, 2, 126, 0, -1, -127}));
  EXPECT_EQ(same(cast(kTfFloat, kTfInt64, 9), {given})[0].values<int64_t>(),
            (std::vector<int64_t>{0, 0, 0, 1, 2, 126, 0, -1, -127}));
  EXPECT_EQ(
      same(cast(kTfFloat, kTfUint8, 4), {floats({0, 0.99f, 2.5f, 255.9f})})[0].values<uint8_t>(),
      (std::vector<uint8_t>{0, 0, 2, 255}));
}

// Integers keep their low bits; floats become the nearest representable value.
TEST_F(LoweredPlainOperators, CastsOfWholeNumbersKeepTheirLowBits) {
  constexpr int32_t kMin = std::numeric_limits<int32_t>::min(),
                    kMax = std::numeric_limits<int32_t>::max();
  const auto given = int32_tensor({0, 1, 127, 128, 255, 256, -1, -128, -129, kMin, kMax, 16777217});
  EXPECT_EQ(same(cast(kTfInt32, kTfUint8, 12), {given})[0].values<uint8_t>(),
            (std::vector<uint8_t>{0, 1, 127, 128, 255, 0, 255, 128, 127, 0, 255, 1}));
  EXPECT_EQ(same(cast(kTfInt32, kTfInt64, 12), {given})[0].values<int64_t>()[9], kMin);
  EXPECT_EQ(same(cast(kTfInt32, kTfFloat, 12), {given})[0].values<float>()[11], 16777216.0f);
  const auto wide = make_tensor<int64_t>(WEIR_INT64, {3}, {-1, (int64_t{1} << 40) + 7, 5});
  EXPECT_EQ(same(cast(kTfInt64, kTfInt32, 3), {wide})[0].values<int32_t>(),
            (std::vector<int32_t>{-1, 7, 5}));
}

TEST_F(LoweredPlainOperators, CastsOf8BitValuesUseTheStoredNumbers) {
  std::vector<uint8_t> all(256);
  for (size_t i = 0; i < all.size(); ++i) all[i] = static_cast<uint8_t>(i);
  auto from_uint8 = TfliteBuilder().input("x", kTfUint8, {256}).quantized({{0.5f}, {7}});
  from_uint8.output("y", kTfFloat, {256}).node(kOpCast, {"x"}, {"y"});
  const auto y = same(from_uint8, {make_tensor<uint8_t>(WEIR_UINT8, {256}, all)});
  ASSERT_EQ(y.size(), 1u);
  EXPECT_EQ(y[0].values<float>()[200], 200.0f) << "its scale is not used";

  auto from_int8 = TfliteBuilder().input("x", kTfInt8, {256}).quantized({{0.5f}, {7}});
  from_int8.output("y", kTfInt32, {256}).node(kOpCast, {"x"}, {"y"});
  const auto z = same(from_int8, {make_tensor<uint8_t>(WEIR_INT8, {256}, all)});
  ASSERT_EQ(z.size(), 1u);
  EXPECT_EQ(z[0].values<int32_t>()[200], -56);

  auto to_int8 = TfliteBuilder().input("x", kTfInt32, {6});
  to_int8.output("y", kTfInt8, {6}).quantized({{1.0f}, {0}}).node(kOpCast, {"x"}, {"y"});
  const auto w = same(to_int8, {int32_tensor({0, -128, 127, 128, 200, -129})});
  ASSERT_EQ(w.size(), 1u);
  EXPECT_EQ(w[0].values<int8_t>(), (std::vector<int8_t>{0, -128, 127, -128, -56, 127}));
}

TEST_F(LoweredPlainOperators, GatherReadsWholeSlicesOfOneAxis) {
  std::vector<float> given(24);
  for (size_t i = 0; i < given.size(); ++i) given[i] = static_cast<float>(i) + 0.25f;
  const auto x = make_tensor<float>(WEIR_FLOAT32, {2, 3, 4}, given);
  for (const auto& [axis, shape] :
       {std::pair<int32_t, std::vector<int32_t>>{1, {2, 2, 2, 4}}, {-1, {2, 3, 2, 2}}}) {
    auto model = TfliteBuilder().input("x", kTfFloat, {2, 3, 4});
    model.constant<int32_t>("at", kTfInt32, {2, 2}, {2, 0, 1, 1})
        .output("y", kTfFloat, shape)
        .node(kGather, {"x", "at"}, {"y"})
        .options(kGatherOptions, FlatValue::table({{0, number(axis)}}));
    const auto y = same(model, {x});
    ASSERT_EQ(y.size(), 1u);
    EXPECT_EQ(y[0].values<float>()[0], axis == 1 ? 8.25f : 2.25f);
  }
}

TEST_F(LoweredPlainOperators, GatherReadsIndicesThatTheGraphComputes) {
  auto model = TfliteBuilder().input("x", kTfInt8, {4}).quantized({{0.5f}, {-3}});
  model.input("at", kTfInt32, {3});
  model.output("y", kTfInt8, {3}).quantized({{0.5f}, {-3}});
  model.node(kGather, {"x", "at"}, {"y"}).options(kGatherOptions, FlatValue::table({}));
  const auto y = same(
      model, {make_tensor<int8_t>(WEIR_INT8, {4}, {-128, -1, 5, 127}), int32_tensor({3, 0, 2})});
  ASSERT_EQ(y.size(), 1u);
  EXPECT_EQ(y[0].values<int8_t>(), (std::vector<int8_t>{127, -128, 5}));
}

TEST_F(LoweredPlainOperators, GatherNdReadsSingleElements) {
  auto model = TfliteBuilder().input("x", kTfUint8, {2, 3, 2}).quantized({{0.5f}, {9}});
  model.input("at", kTfInt32, {3, 2});
  model.output("y", kTfUint8, {3, 2}).quantized({{0.5f}, {9}});
  model.node(kGatherNd, {"x", "at"}, {"y"});
  const auto y = same(
      model, {make_tensor<uint8_t>(WEIR_UINT8, {2, 3, 2}, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}),
              make_tensor<int32_t>(WEIR_INT32, {3, 2}, {1, 2, 0, 0, 1, 0})});
  ASSERT_EQ(y.size(), 1u);
  EXPECT_EQ(y[0].values<uint8_t>(), (std::vector<uint8_t>{10, 11, 0, 1, 6, 7}));
}

TEST_F(LoweredPlainOperators, PackAndUnpackUndoEachOther) {
  for (const int32_t axis : {0, 1, -1}) {
    auto model = TfliteBuilder()
                     .input("x", kTfInt32, {2, 3})
                     .input("z", kTfInt32, {2, 3})
                     .tensor("p", kTfInt32,
                             axis == 0   ? std::vector<int32_t>{2, 2, 3}
                             : axis == 1 ? std::vector<int32_t>{2, 2, 3}
                                         : std::vector<int32_t>{2, 3, 2})
                     .output("a", kTfInt32, {2, 3})
                     .output("b", kTfInt32, {2, 3})
                     .output("copy", kTfInt32, {2, 3});
    model.node(kPack, {"x", "z"}, {"p"})
        .options(kPackOptions, FlatValue::table({{0, number(2)}, {1, number(axis)}}))
        .node(kUnpack, {"p"}, {"a", "b"})
        .options(kUnpackOptions, FlatValue::table({{0, number(2)}, {1, number(axis)}}))
        .node(kOpAdd, {"a", "b"}, {"copy"})
        .options(kAddOptions, FlatValue::table({}));
    const auto x = make_tensor<int32_t>(WEIR_INT32, {2, 3}, {1, 2, 3, 4, 5, 6}),
               z = make_tensor<int32_t>(WEIR_INT32, {2, 3}, {7, 8, 9, -1, -2, -3});
    const auto out = same(model, {x, z});
    ASSERT_EQ(out.size(), 3u);
    EXPECT_EQ(out[0].bytes, x.bytes);
    EXPECT_EQ(out[1].bytes, z.bytes);
  }
}

TEST_F(LoweredPlainOperators, ArgMaxReturnsTheFirstOfEqualValues) {
  for (const int8_t type : {int8_t{kTfUint8}, int8_t{kTfInt8}}) {
    auto model = TfliteBuilder().input("x", type, {2, 4}).quantized({{0.5f}, {3}});
    model.constant<int32_t>("axis", kTfInt32, {}, {1})
        .output("y", kTfInt32, {2})
        .node(kArgMax, {"x", "axis"}, {"y"})
        .options(kArgMaxOptions, FlatValue::table({{0, FlatValue::scalar<int8_t>(2)}}));
    const auto y = same(model, {make_tensor<uint8_t>(type == kTfInt8 ? WEIR_INT8 : WEIR_UINT8,
                                                     {2, 4}, {1, 200, 100, 200, 127, 5, 127, 1})});
    ASSERT_EQ(y.size(), 1u);
    EXPECT_EQ(y[0].values<int32_t>(),
              (type == kTfInt8 ? std::vector<int32_t>{2, 0} : std::vector<int32_t>{1, 0}));
  }
}

TEST_F(LoweredPlainOperators, FloorDivisionRoundsDown) {
  auto model = TfliteBuilder().input("x", kTfInt32, {8});
  model.constant<int32_t>("by", kTfInt32, {}, {48})
      .output("y", kTfInt32, {8})
      .node(kFloorDivide, {"x", "by"}, {"y"});
  const auto y = same(
      model, {int32_tensor({0, 47, 48, 2303, -1, -48, -49, std::numeric_limits<int32_t>::max()})});
  ASSERT_EQ(y.size(), 1u);
  EXPECT_EQ(y[0].values<int32_t>(), (std::vector<int32_t>{0, 0, 1, 47, -1, -1, -2, 44739242}));
}

TEST_F(LoweredPlainOperators, RealNumbersAreAddedMultipliedDividedAndRooted) {
  const struct {
    int32_t op;
    uint8_t options;
    std::vector<float> expected;
  } cases[] = {{kOpAdd, kAddOptions, {0, 3, 6, 0}},
               {kOpSub, kSubOptions, {0, 0, 4, 0}},
               {kMultiply, kMultiplyOptions, {0, 2.25f, 5, 6}},
               {kDivide, kDivOptions, {0, 1, 5, 6}}};
  for (const auto& each : cases) {
    auto model =
        TfliteBuilder()
            .input("x", kTfFloat, {4})
            .input("z", kTfFloat, {4})
            .output("y", kTfFloat, {4})
            .node(each.op, {"x", "z"}, {"y"})
            .options(each.options, FlatValue::table({{0, FlatValue::scalar<int8_t>(kRelu6)}}));
    const auto y = same(model, {floats({-4, 1.5f, 5, -7}), floats({2, 1.5f, 1, -1})});
    ASSERT_EQ(y.size(), 1u);
    EXPECT_EQ(y[0].values<float>(), each.expected) << each.op;
  }
  auto root = TfliteBuilder()
                  .input("x", kTfFloat, {4})
                  .output("y", kTfFloat, {4})
                  .node(kSquareRoot, {"x"}, {"y"});
  EXPECT_EQ(same(root, {floats({0, 4, 2.25f, 1e10f})})[0].values<float>(),
            (std::vector<float>{0, 2, 1.5f, 1e5f}));
}

TEST_F(LoweredPlainOperators, WholeNumbersAreJoined) {
  auto model = TfliteBuilder()
                   .input("x", kTfInt32, {2, 1})
                   .input("z", kTfInt32, {2, 2})
                   .output("y", kTfInt32, {2, 3})
                   .node(kOpConcatenation, {"x", "z"}, {"y"})
                   .options(kConcatenationOptions, FlatValue::table({{0, number(1)}}));
  const auto y = same(model, {make_tensor<int32_t>(WEIR_INT32, {2, 1}, {1, 2}),
                              make_tensor<int32_t>(WEIR_INT32, {2, 2}, {3, 4, 5, 6})});
  ASSERT_EQ(y.size(), 1u);
  EXPECT_EQ(y[0].values<int32_t>(), (std::vector<int32_t>{1, 3, 4, 2, 5, 6}));
}

// Every value minus every other; scales of a half and a whole make all of them ties.
TEST_F(LoweredPlainOperators, DifferencesOfUint8AreTheSame) {
  const struct {
    float first, second, out;
    int64_t zero;
  } cases[] = {{0.03f, 0.05f, 0.07f, 93},
               {0.0078431f, 0.00392155f, 0.0078431f, 127},
               {0.00392155f, 0.0078431f, 0.0078431f, 0},
               {1.0f, 1e-6f, 1.0f, 0},
               {0.11f, 0.9f, 0.013f, 255}};
  for (const auto& each : cases) {
    auto model =
        TfliteBuilder().input("x", kTfUint8, {256, 1}).quantized({{each.first}, {each.zero}});
    model.input("z", kTfUint8, {1, 256}).quantized({{each.second}, {131}});
    model.output("y", kTfUint8, {256, 256}).quantized({{each.out}, {each.zero}});
    model.node(kOpSub, {"x", "z"}, {"y"}).options(kSubOptions, FlatValue::table({}));
    std::vector<uint8_t> all(256);
    for (size_t i = 0; i < all.size(); ++i) all[i] = static_cast<uint8_t>(i);
    same(model, {make_tensor<uint8_t>(WEIR_UINT8, {256, 1}, all),
                 make_tensor<uint8_t>(WEIR_UINT8, {1, 256}, all)});
  }
}

// Allows one step: each of the three libraries rounds differently.
TEST_F(LoweredPlainOperators, DifferencesAndLargerPicturesAreAStepApartAtMost) {
  std::vector<TfliteBuilder> models;
  for (const auto& [type, zero] : {std::pair{kTfUint8, 90}, {kTfInt8, -20}}) {
    auto difference = TfliteBuilder().input("x", type, {5, 8}).quantized({{0.03f}, {zero}});
    difference.input("z", type, {5, 8}).quantized({{0.05f}, {zero + 7}});
    difference.output("y", type, {5, 8}).quantized({{0.07f}, {zero + 3}});
    difference.node(kOpSub, {"x", "z"}, {"y"})
        .options(kSubOptions, FlatValue::table({{0, FlatValue::scalar<int8_t>(kRelu)}}));
    if (type == kTfInt8) models.push_back(difference);  // this one runs in XNNPACK
    for (const bool half : {false, true}) {
      auto larger = TfliteBuilder().input("x", type, {1, 6, 5, 3}).quantized({{0.03f}, {zero}});
      larger.constant<int32_t>("size", kTfInt32, {2}, {12, 13});
      larger.output("y", type, {1, 12, 13, 3}).quantized({{0.03f}, {zero}});
      larger.node(kBilinear, {"x", "size"}, {"y"})
          .options(kBilinearOptions, FlatValue::table({{3, FlatValue::scalar<uint8_t>(half)}}));
      models.push_back(larger);
    }
  }
  for (size_t i = 0; i < models.size(); ++i) {
    const auto path = folder_.write("model.tflite", models[i].bytes());
    const auto own = opened(path), other = lowered(path);
    ASSERT_TRUE(own && other) << i;
    Comparison found;
    for (uint32_t seed = 1; seed <= 4; ++seed)
      compare(own.get(), other.get(), random_inputs(*own, seed), &found);
    EXPECT_LE(found.worst, 1) << i;
  }
}

TEST_F(LoweredPlainOperators, OperatorsThatWouldFailOrDifferStayWithTensorFlowLite) {
  const auto divided = [](int32_t by) {
    return TfliteBuilder()
        .input("x", kTfInt32, {2})
        .constant<int32_t>("by", kTfInt32, {}, {by})
        .output("y", kTfInt32, {2})
        .node(kFloorDivide, {"x", "by"}, {"y"});
  };
  EXPECT_SAYS(refused(divided(0)), "FLOOR_DIV (number 1) is not lowered");
  EXPECT_SAYS(refused(divided(-1)), "a divisor below 1");
  const auto gathered = [](const std::vector<int32_t>& at, int32_t batch) {
    return TfliteBuilder()
        .input("x", kTfFloat, {3, 2})
        .constant<int32_t>("at", kTfInt32, {2}, at)
        .output("y", kTfFloat, {2, 2})
        .node(kGather, {"x", "at"}, {"y"})
        .options(kGatherOptions, FlatValue::table({{1, number(batch)}}));
  };
  EXPECT_SAYS(refused(gathered({0, 3}, 0)), "GATHER (number 1) is not lowered");
  EXPECT_SAYS(refused(gathered({0, 3}, 0)), "an index outside the tensor: 3");
  EXPECT_SAYS(refused(gathered({-1, 0}, 0)), "an index outside the tensor: -1");
  EXPECT_SAYS(refused(gathered({1, 0}, 1)), "indices for each part of a batch");
  auto whole = TfliteBuilder()
                   .input("x", kTfInt32, {2})
                   .input("z", kTfInt32, {2})
                   .output("y", kTfInt32, {2})
                   .node(kDivide, {"x", "z"}, {"y"})
                   .options(kDivOptions, FlatValue::table({}));
  EXPECT_SAYS(refused(whole), "a quotient that is not float32");
  auto narrow = TfliteBuilder().input("x", kTfFloat, {2}).tensor("m", kTfInt16, {2});
  narrow.output("y", kTfFloat, {2}).node(kOpCast, {"x"}, {"m"}).node(kOpCast, {"m"}, {"y"});
  EXPECT_SAYS(refused(narrow), "CAST (number 1) is not lowered");
}

}  // namespace unquantised_operators_test
}  // namespace weir::engine_test
