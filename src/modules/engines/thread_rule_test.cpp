// Tests the number of threads for a model's size, and the estimates from graphs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "thread_rule.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "pytorch/torch_work.hpp"
#include "tflite-file/tflite_work.hpp"

namespace weir::engine {
namespace thread_rule_test {

constexpr ThreadCosts kCosts{.of_operator = 1e6, .of_invoke = 10e6, .of_weight = 20};

TEST(ThreadRule, MoreThreadsForMoreWorkUpToTheCores) {
  EXPECT_EQ(threads_for({.multiplications = 8e6, .operators = 4}, kCosts, 4), 1) << "2e6 each";
  EXPECT_EQ(threads_for({.multiplications = 20e6, .operators = 10}, kCosts, 4), 2);
  EXPECT_EQ(threads_for({.multiplications = 35e6, .operators = 10}, kCosts, 4), 3);
  EXPECT_EQ(threads_for({.multiplications = 900e6, .operators = 10}, kCosts, 4), 4);
}

TEST(ThreadRule, ManySmallOperatorsAreForOneThread) {
  EXPECT_EQ(threads_for({.multiplications = 100e6, .operators = 100}, kCosts, 8), 1);
  EXPECT_EQ(threads_for({.multiplications = 100e6, .operators = 10}, kCosts, 8), 8);
}

TEST(ThreadRule, WeightsCountAsTheTimeOfReadingThem) {
  EXPECT_EQ(threads_for({.multiplications = 2e6, .weights = 2e6, .operators = 2}, kCosts, 8), 4);
}

TEST(ThreadRule, InvalidWorkUsesOneThread) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(threads_for({.multiplications = nan, .operators = 1}, kCosts, 8), 1);
  EXPECT_EQ(threads_for({.multiplications = infinity, .operators = 1}, kCosts, 8), 8);
  EXPECT_EQ(threads_for({.multiplications = -infinity, .operators = 1}, kCosts, 8), 1);
}

TEST(ThreadRule, UnknownWorkAndNoCoresUseOneThread) {
  EXPECT_EQ(threads_for({.multiplications = 1e12}, kCosts, 8), 1);
  EXPECT_EQ(threads_for({.multiplications = 1e12, .operators = 1}, kCosts, 0), 1);
}

weir_tensor_info shape(const std::vector<int64_t>& extents) {
  weir_tensor_info info{};
  info.rank = static_cast<uint32_t>(extents.size());
  std::copy(extents.begin(), extents.end(), info.shape);
  return info;
}

// A 3x3 convolution from 3 channels to 8 with stride 2, 2x2 pooling, and, after averaging the
// pixels, a product with a 10 by 8 matrix: 8 * 8 * 8 * 27 + 8 * 10.
TEST(TorchWork, FollowsTheNumbersThroughTheSteps) {
  TorchWork work;
  work.set_inputs(1);
  const auto convolved = work.add(
      {.from = {0}, .growth = 8.0 / 3 / 4, .channels = 8, .multiplications = 27, .weights = 216});
  const auto pooled = work.add({.from = {convolved}, .growth = 0.25});
  const auto averaged = work.add({.from = {pooled}, .positions = 1});
  work.add({.from = {averaged}, .growth = 10.0 / 8, .multiplications = 8, .weights = 80});
  const std::vector<weir_tensor_info> inputs{shape({1, 3, 16, 16})};
  const Work found = work.estimate(inputs);
  EXPECT_DOUBLE_EQ(found.multiplications, 8 * 8 * 8 * 27 + 10 * 8);
  EXPECT_DOUBLE_EQ(found.weights, 216 + 80);
  EXPECT_EQ(found.operators, 2u);
}

TEST(TorchWork, JoinedTensorsAddUp) {
  TorchWork work;
  work.set_inputs(2);
  const auto joined = work.add({.from = {0, 1}, .joins = true});
  work.add({.from = {joined}, .multiplications = 1});
  const std::vector<weir_tensor_info> inputs{shape({1, 4}), shape({1, 6})};
  EXPECT_DOUBLE_EQ(work.estimate(inputs).multiplications, 10);
}

TEST(TorchWork, IsUnknownWhereShapesAreOpen) {
  TorchWork work;
  work.set_inputs(1);
  work.add({.from = {0}, .multiplications = 1});
  weir_tensor_info unknown = shape({});
  unknown.rank = WEIR_RANK_UNKNOWN;
  for (const auto& info : std::vector{shape({1, -1}), unknown})
    EXPECT_EQ(work.estimate(std::vector{info}).operators, 0u);
  EXPECT_EQ(work.estimate({}).operators, 0u) << "another number of inputs";
}

TfliteGraphTensor tensor(std::vector<int64_t> extents, TfliteType type = TfliteType::kFloat32) {
  TfliteGraphTensor out;
  out.shape = std::move(extents);
  out.type = type;
  return out;
}

// CONV_2D 3x3x3 to 8 channels, DEPTHWISE_CONV_2D 3x3, FULLY_CONNECTED 8 to 10.
TfliteGraph small_graph(TfliteType type) {
  TfliteGraph graph;
  graph.tensors = {tensor({1, 16, 16, 3}), tensor({8, 3, 3, 3}, type),
                   tensor({1, 8, 8, 8}),   tensor({1, 3, 3, 8}, type),
                   tensor({1, 8, 8, 8}),   tensor({10, 8}, type),
                   tensor({1, 10})};
  graph.operators.resize(3);
  const int32_t codes[] = {3, 4, 9};
  for (int32_t i = 0; i < 3; ++i) {
    graph.operators[i].code = codes[i];
    graph.operators[i].inputs = {2 * i, 2 * i + 1};
    graph.operators[i].outputs = {2 * i + 2};
  }
  return graph;
}

TEST(TfliteWork, CountsMultiplicationsOfEachKind) {
  for (const auto type : {TfliteType::kFloat32, TfliteType::kInt8}) {
    const Work work = tflite_work(small_graph(type));
    EXPECT_DOUBLE_EQ(work.multiplications, 512 * 27 + 512 * 9 + 10 * 8);
    EXPECT_DOUBLE_EQ(work.weights, 216 + 72 + 80);
    EXPECT_EQ(work.operators, 3u);
  }
}

TEST(TfliteWork, ExcludesOperatorsThatXnnpackDoesNotRun) {
  EXPECT_EQ(tflite_work(small_graph(TfliteType::kUint8)).operators, 0u);
}

TEST(TfliteWork, XnnpackSuitsAllButUint8Products) {
  EXPECT_TRUE(suits_xnnpack(small_graph(TfliteType::kFloat32)));
  EXPECT_TRUE(suits_xnnpack(small_graph(TfliteType::kInt8)));
  auto graph = small_graph(TfliteType::kUint8);
  EXPECT_FALSE(suits_xnnpack(graph));
  graph.tensors[5].type = TfliteType::kFloat32;  // weights of the matrix product
  EXPECT_TRUE(suits_xnnpack(graph));
  graph.operators[2].inputs = {4, -1};
  EXPECT_FALSE(suits_xnnpack(graph));
  graph.operators.clear();
  EXPECT_TRUE(suits_xnnpack(graph));
}

TEST(TfliteWork, ExcludesOpenShapesAndMissingTensors) {
  auto graph = small_graph(TfliteType::kFloat32);
  graph.tensors[2].shape[1] = -1;       // the convolution's output
  graph.operators[1].inputs = {2, -1};  // without weights
  graph.operators[2].outputs = {99};
  EXPECT_EQ(tflite_work(graph).operators, 0u);
}

}  // namespace thread_rule_test
}  // namespace weir::engine
