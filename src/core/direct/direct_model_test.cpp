// Tests invoking without a pipeline: shapes, memory, behaviour of engines.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/direct/direct_test_support.hpp"

namespace weir::direct {
namespace direct_model_test {

using Values = std::vector<float>;

TEST_F(DirectTest, InvokesWithAShapeInTheCall) {
  const auto model = open();
  const Values x{1, 2, 3, 4, 5, 6};
  const auto outcome = model->invoke(std::array{lend(x, {3, 2})});
  ASSERT_TRUE(outcome) << outcome.error().message();
  EXPECT_EQ(values(outcome->results), (Values{2, 3, 4, 5, 6, 7}));
  const auto& info = outcome->results.tensors()[0].info;
  EXPECT_EQ(shape_text(info), "(3, 2)");
  EXPECT_STREQ(info.name, "y");
}

TEST_F(DirectTest, KeepsTheShapeOfReshape) {
  const auto model = open();
  EXPECT_EQ(shape_text(model->outputs()[0]), "(?, 2)");
  ASSERT_TRUE(model->reshape({tensor_info("", WEIR_TYPE_END, {2, 2})}));
  EXPECT_EQ(shape_text(model->inputs()[0]), "(2, 2)");
  EXPECT_EQ(shape_text(model->outputs()[0]), "(2, 2)");
  const Values x{1, 2, 3, 4};
  const auto outcome = model->invoke(std::array{lend(x)});
  ASSERT_TRUE(outcome) << outcome.error().message();
  EXPECT_EQ(values(outcome->results), (Values{2, 3, 4, 5}));
  EXPECT_EQ(TestModel::resolves, 1) << "the same shapes are not resolved again";
}

TEST_F(DirectTest, OpensTheShapeAgain) {
  const auto model = open();
  ASSERT_TRUE(model->reshape({tensor_info("", WEIR_TYPE_END, {1, 2})}));
  weir_tensor_info any{};
  any.type = WEIR_TYPE_END;
  any.rank = WEIR_RANK_UNKNOWN;
  ASSERT_TRUE(model->reshape({any}));
  EXPECT_EQ(shape_text(model->inputs()[0]), "(?, 2)");
  const Values x{1, 2, 3, 4};
  const auto outcome = model->invoke(std::array{lend(x, {2, 2})});
  ASSERT_TRUE(outcome) << outcome.error().message();
  EXPECT_EQ(values(outcome->results), (Values{2, 3, 4, 5}));
}

TEST_F(DirectTest, AShapeInTheCallDoesNotStay) {
  const auto model = open();
  ASSERT_TRUE(model->reshape({tensor_info("", WEIR_TYPE_END, {1, 2})}));
  const Values one{1, 2}, two{1, 2, 3, 4};
  ASSERT_TRUE(model->invoke(std::array{lend(two, {2, 2})}));
  const auto outcome = model->invoke(std::array{lend(one)});
  ASSERT_TRUE(outcome) << outcome.error().message();
  EXPECT_EQ(values(outcome->results), (Values{2, 3}));
}

TEST_F(DirectTest, WritesIntoTheCallersMemory) {
  const auto model = open();
  const Values x{1, 2};
  Values y(2);
  std::array into{lend(y)};
  const void* seen = nullptr;
  TestModel::invoke_body = [&](In in, Out out) {
    seen = out[0].data;
    return add_one(in, out);
  };
  const auto outcome = model->invoke(std::array{lend(x, {1, 2})}, into);
  ASSERT_TRUE(outcome) << outcome.error().message();
  EXPECT_EQ(y, (Values{2, 3}));
  EXPECT_EQ(seen, y.data()) << "no copy between";
  EXPECT_EQ(shape_text(into[0].info), "(1, 2)");
}

TEST_F(DirectTest, ReturnsMemoryThatTheEngineAllocates) {
  TestModel::resolve_body = nullptr;  // the output's first axis stays open
  static int freed;
  freed = 0;
  TestModel::invoke_body = [](In, Out out) {
    EXPECT_EQ(out[0].data, nullptr);
    static float memory[4] = {7, 8, 9, 10};
    out[0].data = memory;
    out[0].bytes = sizeof memory;
    out[0].info.shape[0] = 2;
    out[0].release = [](void*) { ++freed; };
    return true;
  };
  const auto model = open();
  const Values x{1, 2};
  {
    const auto outcome = model->invoke(std::array{lend(x, {1, 2})});
    ASSERT_TRUE(outcome) << outcome.error().message();
    EXPECT_EQ(values(outcome->results), (Values{7, 8, 9, 10}));
    EXPECT_EQ(freed, 0);
  }
  EXPECT_EQ(freed, 1);
  Values y(4);
  std::array into{lend(y)};
  ASSERT_TRUE(model->invoke(std::array{lend(x, {1, 2})}, into));
  EXPECT_EQ(y, (Values{7, 8, 9, 10}));
  EXPECT_EQ(freed, 2);
}

TEST_F(DirectTest, HonoursTheEnginesMemoryRequirements) {
  TestModel::alignment = 256;
  TestModel::padding = 64;
  bool suits = false;
  const void* seen = nullptr;
  TestModel::invoke_body = [&](In in, Out out) {
    seen = in[0].data;
    suits = reinterpret_cast<uintptr_t>(seen) % 256 == 0 && in[0].capacity >= in[0].bytes + 64;
    return add_one(in, out);
  };
  const auto model = open();
  const Values x{1, 2};
  const auto outcome = model->invoke(std::array{lend(x, {1, 2})});
  ASSERT_TRUE(outcome) << outcome.error().message();
  EXPECT_TRUE(suits);
  EXPECT_EQ(values(outcome->results), (Values{2, 3}));
  EXPECT_NE(seen, x.data());
  TestModel::alignment = 4;
  TestModel::padding = 0;
  const auto plain = open();
  ASSERT_TRUE(plain->invoke(std::array{lend(x, {1, 2})}));
  EXPECT_EQ(seen, x.data()) << "read in place";
}

TEST_F(DirectTest, ResultsOutliveTheirModel) {
  auto model = open();
  const Values x{1, 2};
  const auto outcome = model->invoke(std::array{lend(x, {1, 2})});
  ASSERT_TRUE(outcome);
  model.reset();
  EXPECT_EQ(TestModel::closed, 1);
  EXPECT_EQ(values(outcome->results), (Values{2, 3}));
  EXPECT_STREQ(outcome->results.tensors()[0].info.name, "y");
}

TEST_F(DirectTest, ReportsThatAFrameWasDropped) {
  TestModel::invoke_body = [](In, Out) { return false; };
  const auto model = open();
  const Values x{1, 2};
  const auto outcome = model->invoke(std::array{lend(x, {1, 2})});
  ASSERT_TRUE(outcome);
  EXPECT_TRUE(outcome->dropped);
}

TEST_F(DirectTest, ScalarsAndEmptyModelsRun) {
  TestModel::in = {};
  TestModel::out = {tensor_info("n", WEIR_INT64, {})};
  TestModel::resolve_body = nullptr;
  TestModel::invoke_body = [](In in, Out out) {
    EXPECT_TRUE(in.empty());
    *static_cast<int64_t*>(out[0].data) = 42;
    return true;
  };
  const auto model = open();
  const auto outcome = model->invoke({});
  ASSERT_TRUE(outcome) << outcome.error().message();
  EXPECT_EQ(*static_cast<const int64_t*>(outcome->results.tensors()[0].data), 42);
  EXPECT_EQ(outcome->results.tensors()[0].bytes, 8u);
}

}  // namespace direct_model_test
}  // namespace weir::direct
