// Tests which models can run several frames at once, and the errors for the others.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/batch/batch_axis.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "says.hpp"

namespace weir::infer {
namespace batch_axis_test {

using Infos = std::vector<weir_tensor_info>;

weir_tensor_info tensor(std::vector<int64_t> shape, const char* name = "x",
                        uint32_t axis = WEIR_NO_BATCH_AXIS) {
  weir_tensor_info info{};
  info.type = WEIR_FLOAT32;
  info.rank = static_cast<uint32_t>(shape.size());
  std::copy(shape.begin(), shape.end(), info.shape);
  info.name = name;
  info.batch_axis = axis;
  return info;
}
std::vector<int64_t> shape_of(const weir_tensor_info& info) {
  return {info.shape, info.shape + info.rank};
}
Error refused(const Infos& in, const Infos& out, size_t size, uint32_t flags = 0) {
  const auto axes = find_batch_axes(flags, in, out, size);
  EXPECT_FALSE(axes);
  return axes ? Error{} : axes.error();
}

TEST(BatchAxis, AnOpenOutermostAxisFitsAnyBatch) {
  const auto axes = find_batch_axes(0, {tensor({-1, 4})}, {tensor({-1, 2, 2}), tensor({-1})}, 3);
  ASSERT_TRUE(axes);
  EXPECT_FALSE(axes->fixed);
  EXPECT_EQ(axes->inputs, std::vector<uint32_t>{0});
  EXPECT_EQ(axes->outputs, (std::vector<uint32_t>{0, 0}));
}

TEST(BatchAxis, AFixedLengthFitsItsOwnBatch) {
  const auto axes = find_batch_axes(0, {tensor({4, 8})}, {tensor({4, 2})}, 4);
  ASSERT_TRUE(axes);
  EXPECT_TRUE(axes->fixed);
  EXPECT_EQ(shape_of(of_one_frame({tensor({4, 8})}, axes->inputs, 4)[0]),
            (std::vector<int64_t>{1, 8}));
  EXPECT_EQ(shape_of(of_one_frame({tensor({-1, 8})}, axes->inputs, 4)[0]),
            (std::vector<int64_t>{-1, 8}));
}

TEST(BatchAxis, TheEnginesAxisTakesPrecedence) {
  const auto axes = find_batch_axes(0, {tensor({5, -1, 4}, "x", 1)}, {tensor({-1, 4}, "y", 0)}, 2);
  ASSERT_TRUE(axes);
  EXPECT_EQ(axes->inputs, std::vector<uint32_t>{1});
}

TEST(BatchAxis, AModelWithStateIsRejected) {
  const Error error = refused({tensor({-1, 4})}, {tensor({-1, 4})}, 2, WEIR_MODEL_STATEFUL);
  EXPECT_EQ(error.code, Code::BATCH_UNSUPPORTED);
  EXPECT_SAYS(error.what, "keeps state");
  EXPECT_EQ(error.offered, "batch-size=2");
  EXPECT_EQ(error.fix, "set batch-size=1 and give each stream its own tensor_filter");
}

TEST(BatchAxis, AModelForOneFrameIsRejectedWithAFix) {
  const Error error = refused({tensor({-1, 224, 224, 3})}, {tensor({1, 10}, "scores")}, 4);
  EXPECT_EQ(error.code, Code::BATCH_UNSUPPORTED);
  EXPECT_EQ(error.what, "the model cannot run 4 frames at once");
  EXPECT_EQ(error.offered, "in float32 3:224:224:?; out float32 10:1");
  EXPECT_EQ(error.needed, "a first axis that is open, or of length 4, in every input and output");
  EXPECT_EQ(error.difference, "output 0 (scores): dimension 1 is 1");
  EXPECT_EQ(error.fix, "export the model with a dynamic first axis, or set batch-size=1");
}

TEST(BatchAxis, ADifferentFixedLengthIsReported) {
  EXPECT_EQ(refused({tensor({8, 4})}, {tensor({8, 2})}, 4).fix, "batch-size=8");
  EXPECT_EQ(refused({tensor({8, 4})}, {tensor({6, 2})}, 4).fix,
            "export the model with a dynamic first axis, or set batch-size=1");
}

TEST(BatchAxis, AnAxisThatCannotHoldABatchIsReported) {
  EXPECT_EQ(refused({tensor({-1})}, {tensor({-1})}, 2).difference,
            "input 0 (x): its only dimension belongs to one frame");
  EXPECT_EQ(refused({tensor({})}, {tensor({-1})}, 2).difference,
            "input 0 (x): it has no dimension");
  EXPECT_EQ(refused({tensor({-1, 2}, "", 7)}, {tensor({-1})}, 2).difference,
            "input 0: the engine names an axis beyond its rank");
  auto any = tensor({});
  any.rank = WEIR_RANK_UNKNOWN;
  EXPECT_EQ(refused({any}, {tensor({-1})}, 2).difference,
            "input 0 (x): its number of dimensions is unknown");
  EXPECT_EQ(refused({}, {}, 2).code, Code::BATCH_UNSUPPORTED);
}

// A model with the outputs `out`, whose axis is `times` as long as that of the input.
ResolveShapes model(Infos out, int64_t times = 1) {
  return [out, times](const Infos& in) -> Result<Infos> {
    auto found = out;
    for (auto& info : found)
      if (info.rank != WEIR_RANK_UNKNOWN && info.shape[0] == -1)
        info.shape[0] = in[0].shape[0] * times;
    return found;
  };
}

TEST(BatchAxis, TheOutputsOfABatchConsistOfThoseOfItsFrames) {
  const auto shapes =
      shapes_of_batch({{0}, {0}, false}, 4, {tensor({2, 8})}, model({tensor({-1, 5})}, 3));
  ASSERT_TRUE(shapes);
  EXPECT_EQ(shape_of(shapes->outputs[0]), (std::vector<int64_t>{6, 5}));
  EXPECT_EQ(shape_of(shapes->inputs[0]), (std::vector<int64_t>{2, 8}));
}

TEST(BatchAxis, AFixedModelIsQueriedForItsOwnBatchOnly) {
  std::vector<std::vector<int64_t>> requested;
  const auto shapes =
      shapes_of_batch({{0}, {0}, true}, 4, {tensor({1, 8})}, [&](const Infos& in) -> Result<Infos> {
        requested.push_back(shape_of(in[0]));
        return Infos{tensor({4, 5})};
      });
  ASSERT_TRUE(shapes);
  EXPECT_EQ(requested, (std::vector<std::vector<int64_t>>{{4, 8}}));
  EXPECT_EQ(shape_of(shapes->outputs[0]), (std::vector<int64_t>{1, 5}));
}

TEST(BatchAxis, TheLastQueryIsForAFullBatch) {
  std::vector<int64_t> requested;
  const auto shapes = shapes_of_batch({{0}, {0}, false}, 4, {tensor({1, 8})},
                                      [&](const Infos& in) -> Result<Infos> {
                                        requested.push_back(in[0].shape[0]);
                                        return in;
                                      });
  ASSERT_TRUE(shapes);
  EXPECT_EQ(requested.back(), 4) << "an engine that is shaped by it begins in the right shape";
}

TEST(BatchAxis, OutputsThatDoNotGrowWithTheBatchAreRejected) {
  const auto one = tensor({1, 5}, "sum");
  const auto shapes = shapes_of_batch({{0}, {0}, false}, 4, {tensor({1, 8})}, model({one}));
  ASSERT_FALSE(shapes);
  EXPECT_EQ(shapes.error().code, Code::BATCH_UNSUPPORTED);
  EXPECT_EQ(shapes.error().what,
            "the model's outputs cannot be split into one part per frame of a batch");
  EXPECT_EQ(shapes.error().difference,
            "output 0 (sum): float32 5:1 for 4 frames, float32 5:1 for one");
  const auto fixed = shapes_of_batch({{0}, {0}, true}, 4, {tensor({1, 8})}, model({one}));
  ASSERT_FALSE(fixed);
  EXPECT_EQ(fixed.error().code, Code::BATCH_UNSUPPORTED);
}

TEST(BatchAxis, OutputsWhoseSizeDependsOnDataAreRejected) {
  const auto open = tensor({-1, -1}, "boxes");
  const auto shapes = shapes_of_batch({{0}, {0}, false}, 2, {tensor({1, 8})}, model({open}));
  ASSERT_FALSE(shapes);
  EXPECT_EQ(shapes.error().difference, "output 0 (boxes): its size is unknown before the invoke");
}

TEST(BatchAxis, TheModelsErrorAboutShapesIsPassedOn) {
  const auto shapes =
      shapes_of_batch({{0}, {0}, false}, 2, {tensor({1, 8})}, [](const Infos& in) -> Result<Infos> {
        if (in[0].shape[0] == 1) return in;
        return Error{.code = Code::SPEC_MISMATCH, .what = "at most one row"};
      });
  ASSERT_FALSE(shapes);
  EXPECT_EQ(shapes.error().what, "at most one row");
  EXPECT_EQ(shapes.error().fix, "export the model with a dynamic first axis, or set batch-size=1");
}

}  // namespace batch_axis_test
}  // namespace weir::infer
