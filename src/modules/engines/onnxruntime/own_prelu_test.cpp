// Tests our PReLU: it follows the definition for every slopes' axis, and is not used where it
// cannot replace ONNX Runtime's.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "onnxruntime/own_prelu.hpp"

#include <limits>
#include <span>

#include "engine_test_support.hpp"
#include "onnxruntime/onnx_builder_test_support.hpp"
#include "says.hpp"

namespace weir::engine_test {
namespace own_prelu_test {

using engine::with_own_prelu;

class OwnPrelu : public EngineTest {
 protected:
  // x and y: float32 with the given shape; open extents have names.
  static OnnxBuilder model(const std::vector<std::string>& shape,
                           const std::vector<int64_t>& slopes_shape,
                           const std::vector<float>& slopes) {
    return OnnxBuilder()
        .input("x", kFloat, shape)
        .output("y", kFloat, shape)
        .constant("slopes", slopes_shape, slopes)
        .node("PRelu", {"x", "slopes"}, {"y"});
  }
  std::vector<float> run(const OnnxBuilder& model, const std::vector<int64_t>& shape,
                         const std::vector<float>& x, const Options& options = {}) {
    auto opened = EngineTest::open(model.bytes(), options);
    EXPECT_TRUE(opened) << opened.error().message();
    if (!opened) return {};
    const auto y = (*opened)->invoke({make_tensor<float>(WEIR_FLOAT32, shape, x)});
    EXPECT_TRUE(y) << y.error().message();
    return y ? (*y)[0].values<float>() : std::vector<float>();
  }
};

constexpr float kInf = std::numeric_limits<float>::infinity();

TEST_F(OwnPrelu, AppliesASlopePerChannelInPlanes) {
  const auto file = model({"n", "2", "w"}, {2, 1}, {0.5f, -2.f});
  ASSERT_TRUE(with_own_prelu(file.bytes()));
  EXPECT_EQ(run(file, {2, 2, 3}, {1, -2, 0, -1, 3, -4, -6, 7, -8, 9, -10, 11}),
            (std::vector<float>{1, -1, 0, 2, 3, 8, -3, 7, -4, 9, 20, 11}));
}

TEST_F(OwnPrelu, AppliesASlopePerInterleavedChannel) {
  const auto file = model({"n", "3"}, {3}, {2.f, 0.f, -1.f});  // slopes above 1, zero and negative
  ASSERT_TRUE(with_own_prelu(file.bytes()));
  EXPECT_EQ(run(file, {2, 3}, {-1, -1, -1, 1, kInf, -kInf}),
            (std::vector<float>{-2, 0, 1, 1, kInf, kInf}));
}

TEST_F(OwnPrelu, AppliesOneSlopeToAllChannels) {
  const auto file = model({"n"}, {1}, {0.25f});
  ASSERT_TRUE(with_own_prelu(file.bytes()));
  EXPECT_EQ(run(file, {3}, {-4, 4, -8}), (std::vector<float>{-1, 4, -2}));
}

TEST_F(OwnPrelu, AgreesWithOnnxRuntimesOperator) {
  std::vector<float> x, slopes;
  for (int i = 0; i < 5 * 7 * 33; ++i) x.push_back(0.01f * static_cast<float>(i * 37 % 201 - 100));
  for (int i = 0; i < 7; ++i) slopes.push_back(0.3f * static_cast<float>(i - 3));
  const auto file = model({"n", "7", "33"}, {7, 1}, slopes);
  EXPECT_EQ(run(file, {5, 7, 33}, x), run(file, {5, 7, 33}, x, {{"GraphOptimization", "basic"}}));
}

TEST_F(OwnPrelu, CanWorkInPlaceBetweenOtherOperators) {
  const auto file = OnnxBuilder()
                        .input("x", kFloat, {"n", "2"})
                        .output("y", kFloat, {"n", "2"})
                        .constant("slopes", {2}, std::vector<float>{0.5f, 3.f})
                        .node("Neg", {"x"}, {"a"})
                        .node("PRelu", {"a", "slopes"}, {"b"})
                        .node("PRelu", {"b", "slopes"}, {"c"})
                        .node("Add", {"b", "c"}, {"y"});
  EXPECT_EQ(run(file, {2, 2}, {4, 1, -1, -2}), (std::vector<float>{-3, -12, 2, 4}));
}

TEST_F(OwnPrelu, KeepsOpenSizesOpenWithoutAWarning) {
  auto opened = EngineTest::open(model({"n", "2", "w"}, {2, 1}, {0.5f, 1.f}).bytes(), {});
  ASSERT_TRUE(opened) << opened.error().message();
  EXPECT_EQ(to_shape((*opened)->outputs()[0]), (std::vector<int64_t>{-1, 2, -1}));
  take_log();
  for (const int64_t length : {3, 4})
    ASSERT_TRUE((*opened)->invoke({make_tensor(WEIR_FLOAT32, {1, 2, length})}));
  EXPECT_EQ(take_log(), std::vector<std::string>());
}

TEST_F(OwnPrelu, ReplacesNoOtherOperator) {
  const auto relu =
      OnnxBuilder().input("x", kFloat, {"3"}).output("y", kFloat, {"3"}).node("Relu", {"x"}, {"y"});
  EXPECT_FALSE(with_own_prelu(relu.bytes()));
  EXPECT_FALSE(with_own_prelu(model({"n", "2", "2"}, {2}, {1, 2}).opset(6).bytes()))
      << "slopes of channels, on any axis";
  EXPECT_TRUE(with_own_prelu(model({"n", "2", "2"}, {2}, {1, 2}).opset(7).bytes()));
  EXPECT_FALSE(with_own_prelu(model({"n", "2", "2"}, {2, 2}, {1, 2, 3, 4}).bytes()))
      << "a slope for each number";
  const auto computed = OnnxBuilder()
                            .input("x", kFloat, {"3"})
                            .input("slopes", kFloat, {"3"})
                            .output("y", kFloat, {"3"})
                            .node("PRelu", {"x", "slopes"}, {"y"});
  EXPECT_FALSE(with_own_prelu(computed.bytes())) << "slopes that come with the frame";
  const auto replaced = OnnxBuilder()
                            .input("x", kFloat, {"1"})
                            .input("slopes", kFloat, {"1"})
                            .output("y", kFloat, {"1"})
                            .constant("slopes", {1}, std::vector<float>{2.f})
                            .node("PRelu", {"x", "slopes"}, {"y"});
  EXPECT_FALSE(with_own_prelu(replaced.bytes())) << "a constant that an input may replace";
}

TEST_F(OwnPrelu, DoesNotChangeDamagedFiles) {
  auto bytes = model({"n"}, {1}, {0.25f}).bytes();
  for (size_t size = 0; size < bytes.size(); ++size)
    with_own_prelu(std::span(bytes).first(size));  // must not read past the end
  bytes.resize(bytes.size() - 1);
  EXPECT_FALSE(with_own_prelu(bytes));
}

TEST_F(OwnPrelu, WithAWrongNumberOfSlopesIsRejected) {
  auto opened = EngineTest::open(model({"n", "c"}, {3}, {1, 2, 3}).bytes(), {});
  ASSERT_TRUE(opened) << opened.error().message();
  const auto y = (*opened)->invoke({make_tensor<float>(WEIR_FLOAT32, {1, 2}, {1, 2})});
  ASSERT_FALSE(y);
  EXPECT_SAYS(y.error().message(),
              "PRelu: the number of slopes differs from the number of channels");
}

}  // namespace own_prelu_test
}  // namespace weir::engine_test
