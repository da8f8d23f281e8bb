// Tests several frames in one invoke.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <array>

#include "core/direct/direct_test_support.hpp"

namespace weir::direct {
namespace batch_test {

using Values = std::vector<float>;
const Values kA{1, 2}, kB{3, 4}, kC{5, 6};

TEST_F(DirectTest, BatchesFramesAndSplitsTheOutputs) {
  const auto model = open();
  int invokes = 0;
  TestModel::invoke_body = [&](In in, Out out) {
    ++invokes;
    EXPECT_EQ(shape_text(in[0].info), "(3, 2)");
    return add_one(in, out);
  };
  const auto outcome = model->invoke_batch(std::array{lend(kA), lend(kB), lend(kC, {1, 2})}, 3);
  ASSERT_TRUE(outcome) << outcome.error().message();
  EXPECT_EQ(invokes, 1);
  EXPECT_EQ(outcome->results.frames(), 3u);
  EXPECT_EQ(values(outcome->results), (Values{2, 3, 4, 5, 6, 7}));
  const auto second = outcome->results.of_frame(1, 0);
  EXPECT_EQ(shape_text(second.info), "(1, 2)");
  EXPECT_EQ((Values{floats(second).begin(), floats(second).end()}), (Values{4, 5}));
}

TEST_F(DirectTest, BatchesEachOfSeveralInputs) {
  TestModel::in.push_back(tensor_info("k", WEIR_FLOAT32, {-1, 1}));
  TestModel::invoke_body = [](In in, Out out) {
    for (size_t i = 0; i < 4; ++i)
      static_cast<float*>(out[0].data)[i] = floats(in[0])[i] * floats(in[1])[i / 2];
    return true;
  };
  const Values ten{10}, hundred{100};
  const auto outcome =
      open()->invoke_batch(std::array{lend(kA), lend(ten), lend(kB), lend(hundred)}, 2);
  ASSERT_TRUE(outcome) << outcome.error().message();
  EXPECT_EQ(values(outcome->results), (Values{10, 20, 300, 400}));
}

// The list declares tensors that do not exist: only the first may be read.
TEST_F(DirectTest, RejectsMoreFramesThanMemoryHolds) {
  TestModel::in = {tensor_info("x", WEIR_FLOAT32, {-1, int64_t{1} << 40})};
  const float first = 1;
  weir_tensor tensor = lend(std::span(&first, 1), {1, int64_t{1} << 40});
  tensor.bytes = tensor.capacity = sizeof(float) * (uint64_t{1} << 40);
  const size_t frames = size_t{1} << 31;
  EXPECT_REFUSED(open()->invoke_batch(std::span(&tensor, frames), frames), OUT_OF_MEMORY,
                 "(2147483648, 1099511627776)");
}

TEST_F(DirectTest, FillsAModelWhoseBatchIsFixed) {
  TestModel::in = {tensor_info("x", WEIR_FLOAT32, {2, 2})};
  TestModel::out = {tensor_info("y", WEIR_FLOAT32, {2, 2})};
  TestModel::resolve_body = nullptr;
  const auto model = open();
  const auto outcome = model->invoke_batch(std::array{lend(kA), lend(kB)}, 2);
  ASSERT_TRUE(outcome) << outcome.error().message();
  EXPECT_EQ(values(outcome->results), (Values{2, 3, 4, 5}));
  EXPECT_REFUSED(model->invoke_batch(std::array{lend(kA), lend(kB), lend(kC)}, 3),
                 BATCH_UNSUPPORTED,
                 "input 0 (x) cannot hold 3 frames\n  offered: float32 (2, 2) x\n"
                 "  needed: a free axis 0");
}

TEST_F(DirectTest, RejectsABatchWhereNoAxisIsFree) {
  TestModel::in = {tensor_info("x", WEIR_FLOAT32, {1, -1})};
  EXPECT_REFUSED(open()->invoke_batch(std::array{lend(kA), lend(kB)}, 2), BATCH_UNSUPPORTED,
                 "fix: invoke the frames one by one");
  TestModel::in = {tensor_info("x", WEIR_FLOAT32, {-1, 2})};
  TestModel::in[0].batch_axis = 1;
  EXPECT_REFUSED(open()->invoke_batch(std::array{lend(kA), lend(kB)}, 2), BATCH_UNSUPPORTED,
                 "a free axis 0");
  TestModel::in = {tensor_info("x", WEIR_FLOAT32, {})};
  EXPECT_REFUSED(open()->invoke_batch(std::array{lend(kA), lend(kB)}, 2), BATCH_UNSUPPORTED,
                 "a free axis 0");
}

TEST_F(DirectTest, RejectsABatchOfAModelThatKeepsState) {
  TestModel::flags = WEIR_MODEL_STATEFUL;
  EXPECT_REFUSED(open()->invoke_batch(std::array{lend(kA), lend(kB)}, 2), BATCH_UNSUPPORTED,
                 "the model keeps state between frames");
}

TEST_F(DirectTest, RejectsOutputsThatDoNotHoldTheFrames) {
  TestModel::out = {tensor_info("mean", WEIR_FLOAT32, {1, 2})};
  TestModel::resolve_body = nullptr;
  TestModel::invoke_body = [](In, Out out) {
    static_cast<float*>(out[0].data)[0] = static_cast<float*>(out[0].data)[1] = 0;
    return true;
  };
  EXPECT_REFUSED(open()->invoke_batch(std::array{lend(kA), lend(kB)}, 2), BATCH_UNSUPPORTED,
                 "output 0 (mean) does not hold the frames of the batch");
}

TEST_F(DirectTest, RejectsIncompleteFramesAndDifferentShapes) {
  TestModel::in = {tensor_info("x", WEIR_FLOAT32, {-1, -1})};
  const auto model = open();
  const Values three{1, 2, 3};
  EXPECT_REFUSED(model->invoke_batch({}, 0), SPEC_MISMATCH,
                 "is not a multiple of the model's inputs");
  EXPECT_REFUSED(model->invoke_batch(std::array{lend(kA)}, 2), SPEC_MISMATCH,
                 "1 tensors for 2 frames");
  EXPECT_REFUSED(model->invoke_batch(std::array{lend(kA, {1, 2}), lend(three, {1, 3})}, 2),
                 SPEC_MISMATCH, "frame 1: float32 (1, 3) x");
  EXPECT_REFUSED(model->invoke_batch(std::array{lend(kA, {2, 1}), lend(kB, {2, 1})}, 2),
                 SPEC_MISMATCH, "axis 0 is 2 instead of 1");
  EXPECT_REFUSED(model->invoke_batch(std::array{lend(kA), lend(kB)}, 2), SPEC_MISMATCH,
                 "the model leaves a shape open");
}

}  // namespace batch_test
}  // namespace weir::direct
