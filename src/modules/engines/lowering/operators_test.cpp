// Tests each operator alone: the lowered graph and TensorFlow Lite on the same random frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <array>

#include "lowering/lowering_test_support.hpp"
#include "says.hpp"

namespace weir::engine_test {
namespace operators_test {

// Values of BuiltinOperator.
enum : int32_t {
  kAveragePool = 1,
  kConvolution = 3,
  kDepthwise = 4,
  kLogistic = 14,
  kMaxPool = 17,
  kMultiply = 18,
  kSoftmax = 25,
  kPad = 34,
  kStridedSlice = 45,
  kTransposed = 67,
  kNearest = 97,
  kQuantize = 114
};
// Values of BuiltinOptions.
enum : uint8_t {
  kConvolutionOptions = 1,
  kDepthwiseOptions = 2,
  kPoolOptions = 5,
  kFullyConnectedOptions = 8,
  kSoftmaxOptions = 9,
  kConcatenationOptions = 10,
  kAddOptions = 11,
  kMultiplyOptions = 21,
  kStridedSliceOptions = 32,
  kTransposedOptions = 49,
  kNearestOptions = 74
};
constexpr int8_t kSame = 0, kValid = 1;
constexpr int8_t kNoActivation = 0, kRelu = 1, kRelu6 = 3, kTanh = 4;

FlatValue byte(int8_t value) {
  return FlatValue::scalar(value);
}
FlatValue number(int32_t value) {
  return FlatValue::scalar(value);
}
FlatValue convolution(int8_t padding, int32_t stride, int8_t activation, int32_t dilation = 1) {
  return FlatValue::table({{0, byte(padding)},
                           {1, number(stride)},
                           {2, number(stride)},
                           {3, byte(activation)},
                           {4, number(dilation)},
                           {5, number(dilation)}});
}
FlatValue depthwise(int8_t padding, int32_t stride, int32_t multiplier, int8_t activation) {
  return FlatValue::table({{0, byte(padding)},
                           {1, number(stride)},
                           {2, number(stride)},
                           {3, number(multiplier)},
                           {4, byte(activation)}});
}
FlatValue pool(int8_t padding, int32_t stride, int32_t size, int8_t activation) {
  return FlatValue::table({{0, byte(padding)},
                           {1, number(stride)},
                           {2, number(stride)},
                           {3, number(size)},
                           {4, number(size)},
                           {5, byte(activation)}});
}

template <class T>
std::vector<T> random_values(size_t count, int min, int max) {
  static std::mt19937 random(7);
  std::vector<T> out(count);
  for (auto& value : out)
    value = static_cast<T>(std::uniform_int_distribution<int>(min, max)(random));
  return out;
}
std::vector<uint8_t> weights(size_t count) {
  return random_values<uint8_t>(count, 0, 255);
}
std::vector<int8_t> signed_weights(size_t count) {
  return random_values<int8_t>(count, -127, 127);
}
std::vector<int32_t> biases(size_t count) {
  return random_values<int32_t>(count, -900, 900);
}

class LoweredOperators : public LoweringTest {
 protected:
  // The largest difference in quantisation steps over a few frames. -1 when either does not run.
  int steps(const TfliteBuilder& model) {
    const auto path = folder_.write("model.tflite", model.bytes());
    const auto own = opened(path), other = lowered(path);
    if (!own || !other) return -1;
    Comparison found;
    for (uint32_t seed = 1; seed <= 6; ++seed)
      compare(own.get(), other.get(), random_inputs(*own, seed), &found);
    return HasFatalFailure() ? -1 : found.worst;
  }
  std::vector<uint8_t> run(const TfliteBuilder& model, const std::vector<TestTensor>& inputs) {
    const auto other = lowered(folder_.write("model.tflite", model.bytes()));
    if (!other) return {};
    const auto out = other->invoke(inputs);
    if (!out) ADD_FAILURE() << out.error().message();
    return out ? (*out)[0].values<uint8_t>() : std::vector<uint8_t>{};
  }
  // The log text for a model that stays with TensorFlow Lite.
  std::string fallback(const TfliteBuilder& model) {
    take_log();
    (void)open(model.bytes(), kLowered);
    return logged();
  }
};

TfliteBuilder picture(int8_t type, const std::vector<int32_t>& shape, float scale = 0.02f,
                      int64_t zero = 128) {
  return TfliteBuilder().input("x", type, shape).quantized({{scale}, {zero}});
}
TfliteBuilder& result(TfliteBuilder* model, int8_t type, const std::vector<int32_t>& shape,
                      float scale, int64_t zero) {
  return model->output("y", type, shape).quantized({{scale}, {zero}});
}

TfliteBuilder convolution_of_uint8(int32_t size, int8_t padding, int32_t stride, int32_t side_out,
                                   float scale_out, int64_t zero_out, int8_t activation,
                                   int32_t dilation = 1) {
  auto model = picture(kTfUint8, {1, 11, 11, 5});
  model.constant<uint8_t>("w", kTfUint8, {7, size, size, 5}, weights(size_t(35 * size * size)))
      .quantized({{0.005f}, {121}})
      .constant<int32_t>("b", kTfInt32, {7}, biases(7))
      .quantized({{0.0001f}, {0}});
  return result(&model, kTfUint8, {1, side_out, side_out, 7}, scale_out, zero_out)
      .node(kConvolution, {"x", "w", "b"}, {"y"})
      .options(kConvolutionOptions, convolution(padding, stride, activation, dilation));
}

#ifdef __aarch64__  // docs/guide/lowering.md
constexpr int kConvolutionSteps = 1;
#else
constexpr int kConvolutionSteps = 0;
#endif

TEST_F(LoweredOperators, ConvolutionsOfUint8AreTheSame) {
  const auto expect_same = [&](const TfliteBuilder& model) {
    const int found = steps(model);
    EXPECT_TRUE(found >= 0 && found <= kConvolutionSteps) << found;
  };
  expect_same(convolution_of_uint8(1, kSame, 1, 11, 0.03f, 128, kNoActivation));
  expect_same(convolution_of_uint8(3, kSame, 1, 11, 0.09f, 120, kNoActivation));
  expect_same(convolution_of_uint8(3, kSame, 2, 6, 6 / 255.0f, 0, kRelu6));
  expect_same(convolution_of_uint8(3, kValid, 2, 5, 0.05f, 90, kRelu));
  expect_same(convolution_of_uint8(3, kValid, 1, 7, 0.06f, 90, kNoActivation, 2));
  // A multiplier above 0.5.
  expect_same(convolution_of_uint8(1, kSame, 1, 11, 0.00015f, 128, kNoActivation));
}

TEST_F(LoweredOperators, ConvolutionsOfInt8WithAScaleForEachChannelAreTheSame) {
  const std::vector<float> scales{0.004f, 0.001f, 0.01f, 0.002f};
  for (const int32_t size : {1, 3}) {
    auto model = picture(kTfInt8, {1, 9, 9, 6}, 0.02f, -5);
    model
        .constant<int8_t>("w", kTfInt8, {4, size, size, 6},
                          signed_weights(size_t(24 * size * size)))
        .quantized({scales, {0, 0, 0, 0}, 0})
        .constant<int32_t>("b", kTfInt32, {4}, biases(4))
        .quantized({{8e-5f, 2e-5f, 2e-4f, 4e-5f}, {0, 0, 0, 0}, 0});
    result(&model, kTfInt8, {1, 9, 9, 4}, 0.04f, 3)
        .node(kConvolution, {"x", "w", "b"}, {"y"})
        .options(kConvolutionOptions, convolution(kSame, 1, kRelu));
    EXPECT_LE(steps(model), 1) << size;
    EXPECT_GE(steps(model), 0) << size;
  }
}

TEST_F(LoweredOperators, DepthwiseConvolutionsAreTheSame) {
  auto model = picture(kTfUint8, {1, 10, 10, 4});
  model.constant<uint8_t>("w", kTfUint8, {1, 3, 3, 8}, weights(72))
      .quantized({{0.005f}, {100}})
      .constant<int32_t>("b", kTfInt32, {8}, biases(8))
      .quantized({{0.0001f}, {0}});
  result(&model, kTfUint8, {1, 5, 5, 8}, 6 / 255.0f, 0)
      .node(kDepthwise, {"x", "w", "b"}, {"y"})
      .options(kDepthwiseOptions, depthwise(kSame, 2, 2, kRelu6));
  EXPECT_EQ(steps(model), 0);

  auto of_int8 = picture(kTfInt8, {1, 10, 10, 3}, 0.02f, 0);
  of_int8.constant<int8_t>("w", kTfInt8, {1, 3, 3, 3}, signed_weights(27))
      .quantized({{0.004f, 0.001f, 0.01f}, {0, 0, 0}, 3})
      .constant<int32_t>("b", kTfInt32, {3}, biases(3))
      .quantized({{8e-5f, 2e-5f, 2e-4f}, {0, 0, 0}, 0});
  result(&of_int8, kTfInt8, {1, 8, 8, 3}, 0.03f, -20)
      .node(kDepthwise, {"x", "w", "b"}, {"y"})
      .options(kDepthwiseOptions, depthwise(kValid, 1, 1, kNoActivation));
  EXPECT_LE(steps(of_int8), 1);
  EXPECT_GE(steps(of_int8), 0);
}

TEST_F(LoweredOperators, FullyConnectedLayersAreTheSame) {
  auto model = picture(kTfUint8, {2, 3, 20});
  model.constant<uint8_t>("w", kTfUint8, {6, 60}, weights(360))
      .quantized({{0.005f}, {130}})
      .constant<int32_t>("b", kTfInt32, {6}, biases(6))
      .quantized({{0.0001f}, {0}});
  result(&model, kTfUint8, {2, 6}, 0.05f, 128)
      .node(kOpFullyConnected, {"x", "w", "b"}, {"y"})
      .options(kFullyConnectedOptions, FlatValue::table({{0, byte(kRelu)}}));
  EXPECT_EQ(steps(model), 0);

  auto of_int8 = picture(kTfInt8, {1, 32}, 0.02f, 4);
  of_int8.constant<int8_t>("w", kTfInt8, {5, 32}, signed_weights(160)).quantized({{0.005f}, {0}});
  result(&of_int8, kTfInt8, {1, 5}, 0.03f, -1)
      .node(kOpFullyConnected, {"x", "w", ""}, {"y"})
      .options(kFullyConnectedOptions, FlatValue::table({{0, byte(kNoActivation)}}));
  EXPECT_LE(steps(of_int8), 1);
  EXPECT_GE(steps(of_int8), 0);
}

TEST_F(LoweredOperators, TransposedConvolutionsAreTheSame) {
  for (const auto& [padding, side] : {std::pair{kSame, 8}, {kValid, 9}}) {
    auto model = picture(kTfUint8, {1, 4, 4, 3});
    model.constant<int32_t>("size", kTfInt32, {4}, {1, side, side, 2})
        .constant<uint8_t>("w", kTfUint8, {2, 3, 3, 3}, weights(54))
        .quantized({{0.005f}, {120}});
    result(&model, kTfUint8, {1, side, side, 2}, 0.04f, 125)
        .node(kTransposed, {"size", "w", "x"}, {"y"})
        .options(kTransposedOptions,
                 FlatValue::table({{0, byte(padding)}, {1, number(2)}, {2, number(2)}}));
    EXPECT_LE(steps(model), 1) << side;
    EXPECT_GE(steps(model), 0) << side;
  }
}

TEST_F(LoweredOperators, PoolsAreTheSame) {
  const std::tuple<int32_t, int8_t, int32_t, int32_t, int32_t, int32_t> cases[] = {
      {kAveragePool, kValid, 1, 6, 6, 1},
      {kAveragePool, kSame, 2, 3, 7, 4},
      {kAveragePool, kValid, 2, 2, 6, 3},
      {kMaxPool, kSame, 2, 3, 7, 4},
      {kMaxPool, kValid, 1, 2, 6, 5}};
  for (const auto& [op, padding, stride, size, side, side_out] : cases)
    for (const auto& [type, zero] : {std::pair{kTfUint8, 100}, {kTfInt8, -20}}) {
      auto model = picture(type, {1, side, side, 3}, 0.1f, zero);
      result(&model, type, {1, side_out, side_out, 3}, 0.1f, zero)
          .node(op, {"x"}, {"y"})
          .options(kPoolOptions, pool(padding, stride, size, kRelu));
      EXPECT_EQ(steps(model), 0) << op << " " << side << " " << int(type);
    }
}

TEST_F(LoweredOperators, SumsAndProductsAreAStepApartAtMost) {
  for (const auto& [op, kind] :
       {std::pair{kOpAdd + 0, kAddOptions}, {kMultiply + 0, kMultiplyOptions}})
    for (const auto& [type, zero] : {std::pair{kTfUint8, 90}, {kTfInt8, -20}}) {
      auto model = picture(type, {1, 5, 5, 8}, 0.03f, zero);
      model.input("z", type, {1, 5, 5, 8}).quantized({{0.05f}, {zero + 7}});
      result(&model, type, {1, 5, 5, 8}, 0.07f, zero + 3)
          .node(op, {"x", "z"}, {"y"})
          .options(kind, FlatValue::table({{0, byte(kRelu)}}));
      EXPECT_LE(steps(model), 1) << op << " " << int(type);
      EXPECT_GE(steps(model), 0) << op << " " << int(type);
    }
}

TEST_F(LoweredOperators, CurvesAreAStepApartAtMost) {
  for (const auto& [type, zero] : {std::pair{kTfUint8, 128}, {kTfInt8, 0}}) {
    auto logistic = picture(type, {1, 300}, 0.05f, zero);
    result(&logistic, type, {1, 300}, 1 / 256.0f, zero - 128).node(kLogistic, {"x"}, {"y"});
    EXPECT_LE(steps(logistic), 1);
    EXPECT_GE(steps(logistic), 0);
    auto softmax = picture(type, {2, 20}, 0.05f, zero);
    result(&softmax, type, {2, 20}, 1 / 256.0f, zero - 128)
        .node(kSoftmax, {"x"}, {"y"})
        .options(kSoftmaxOptions, FlatValue::table({{0, FlatValue::scalar(0.5f)}}));
    EXPECT_LE(steps(softmax), 1);
    EXPECT_GE(steps(softmax), 0);
  }
}

// Expected values: x / 2 - 5 for 0, 10, 11, 255 at scale 0.5 and zero point 10.
TEST_F(LoweredOperators, QuantizeAndDequantizeRoundTrip) {
  auto model = TfliteBuilder().input("x", kTfFloat, {4});
  model.tensor("q", kTfInt8, {4}).quantized({{0.5f}, {-118}});
  model.tensor("r", kTfUint8, {4}).quantized({{0.25f}, {20}});
  model.output("y", kTfFloat, {4})
      .node(kQuantize, {"x"}, {"q"})
      .node(kQuantize, {"q"}, {"r"})
      .node(kOpDequantize, {"r"}, {"y"});
  const auto other = lowered(folder_.write("model.tflite", model.bytes()));
  ASSERT_NE(other, nullptr);
  const auto y =
      other->invoke({make_tensor<float>(WEIR_FLOAT32, {4}, {-9.0f, 0.6f, 1.1f, 1000.0f})});
  ASSERT_TRUE(y) << y.error().message();
  // The range of int8 is -5 to 122.5; that of uint8 with scale 0.25 is -5 to 58.75.
  EXPECT_EQ((*y)[0].values<float>(), (std::vector<float>{-5.0f, 0.5f, 1.0f, 58.75f}));
}

TEST_F(LoweredOperators, MovesKeepTheValues) {
  auto pad = picture(kTfUint8, {1, 2, 2, 1}, 0.5f, 9);
  pad.constant<int32_t>("p", kTfInt32, {4, 2}, {0, 0, 1, 0, 0, 2, 0, 0});
  result(&pad, kTfUint8, {1, 3, 4, 1}, 0.5f, 9).node(kPad, {"x", "p"}, {"y"});
  const auto four = make_tensor<uint8_t>(WEIR_UINT8, {1, 2, 2, 1}, {1, 2, 3, 4});
  EXPECT_EQ(run(pad, {four}), (std::vector<uint8_t>{9, 9, 9, 9, 1, 2, 9, 9, 3, 4, 9, 9}));

  auto slice = picture(kTfUint8, {2, 6}, 0.5f, 9);
  slice.constant<int32_t>("begin", kTfInt32, {2}, {-1, 1})
      .constant<int32_t>("end", kTfInt32, {2}, {7, 0})
      .constant<int32_t>("step", kTfInt32, {2}, {1, 2});
  result(&slice, kTfUint8, {3}, 0.5f, 9)
      .node(kStridedSlice, {"x", "begin", "end", "step"}, {"y"})
      .options(kStridedSliceOptions, FlatValue::table({{1, number(2)}, {4, number(1)}}));
  EXPECT_EQ(run(slice, {make_tensor<uint8_t>(WEIR_UINT8, {2, 6},
                                             {0, 1, 2, 3, 4, 5, 10, 11, 12, 13, 14, 15})}),
            (std::vector<uint8_t>{11, 13, 15}));

  auto joined = picture(kTfUint8, {1, 2}, 0.5f, 10);
  joined.input("z", kTfUint8, {1, 2}).quantized({{1.0f}, {0}});
  result(&joined, kTfUint8, {1, 4}, 0.5f, 10)
      .node(kOpConcatenation, {"x", "z"}, {"y"})
      .options(kConcatenationOptions, FlatValue::table({{0, number(-1)}}));
  EXPECT_EQ(run(joined, {make_tensor<uint8_t>(WEIR_UINT8, {1, 2}, {3, 4}),
                         make_tensor<uint8_t>(WEIR_UINT8, {1, 2}, {5, 200})}),
            (std::vector<uint8_t>{3, 4, 20, 255}));
}

TEST_F(LoweredOperators, NearestNeighboursAreTheSame) {
  for (const auto& [corners, centres] : {std::pair{0, 0}, {1, 0}, {0, 1}})
    for (const int32_t side : {10, 7, 3}) {
      auto model = picture(kTfInt8, {1, 5, 5, 2}, 0.5f, 9);
      model.constant<int32_t>("size", kTfInt32, {2}, {side, side});
      result(&model, kTfInt8, {1, side, side, 2}, 0.5f, 9)
          .node(kNearest, {"x", "size"}, {"y"})
          .options(kNearestOptions,
                   FlatValue::table({{0, byte(int8_t(corners))}, {1, byte(int8_t(centres))}}));
      EXPECT_EQ(steps(model), 0) << corners << centres << " " << side;
    }
}

TEST_F(LoweredOperators, UnsupportedUsesAreReportedWithTheirReason) {
  const auto tanh = fallback(convolution_of_uint8(1, kSame, 1, 11, 0.03f, 128, kTanh));
  EXPECT_SAYS(tanh, "the operator CONV_2D (number 1) is not lowered");
  EXPECT_SAYS(tanh, "fused activation number 4");

  auto real = TfliteBuilder()
                  .input("x", kTfFloat, {2})
                  .output("y", kTfFloat, {2})
                  .node(kLogistic, {"x"}, {"y"});
  const auto words = fallback(real);
  EXPECT_SAYS(words, "the operator LOGISTIC (number 1) is not lowered");
  EXPECT_SAYS(words, "a tensor is not quantised: tensor x");

  const auto shape = fallback(convolution_of_uint8(3, kSame, 2, 5, 0.03f, 128, kNoActivation));
  EXPECT_SAYS(shape, "an output of 5 rows or columns where the window gives 6");
}

}  // namespace operators_test
}  // namespace weir::engine_test
