// Tests the inputs of a batch, the outputs of each frame, and failing batches.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/batch/batch_runner.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "core/infer/queue/numbered_job_test_support.hpp"
#include "weir/abi.h"

namespace weir::infer {
namespace batch_runner_test {

using namespace std::chrono_literals;
using Ends = std::vector<NumberedJob::End>;

weir_tensor_info tensor(std::vector<int64_t> shape) {
  weir_tensor_info info{};
  info.type = WEIR_FLOAT32;
  info.rank = static_cast<uint32_t>(shape.size());
  std::copy(shape.begin(), shape.end(), info.shape);
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  return info;
}
// Frames of two values; outputs of two values and of one.
BatchShapes two_outputs(size_t batch_size, bool fixed = false) {
  return {{{0}, {0, 0}, fixed}, batch_size, {tensor({1, 2})}, {tensor({1, 2}), tensor({1})}};
}

// y = 10 x, and the sum of each row; records its inputs.
struct Model {
  BatchRunner::Invoke invoke() {
    return [this](const weir_frame& in, weir_frame& out, InvokeEnd*) -> Result<bool> {
      const weir_tensor& x = in.tensors[0];
      const auto* from = static_cast<const float*>(x.data);
      rows.push_back(x.info.shape[0]);
      given.emplace_back(from, from + x.bytes / sizeof *from);
      places.push_back(x.data);
      EXPECT_EQ(x.bytes, static_cast<uint64_t>(x.info.shape[0]) * 2 * sizeof(float));
      EXPECT_EQ(out.tensors[0].info.shape[0], x.info.shape[0]);
      EXPECT_EQ(out.tensors[1].bytes, static_cast<uint64_t>(x.info.shape[0]) * sizeof(float));
      EXPECT_EQ(in.pts, -1);
      auto* y = static_cast<float*>(out.tensors[0].data);
      auto* sum = static_cast<float*>(out.tensors[1].data);
      for (int64_t row = 0; row < x.info.shape[0]; ++row) {
        y[2 * row] = 10 * from[2 * row];
        y[2 * row + 1] = 10 * from[2 * row + 1];
        sum[row] = from[2 * row] + from[2 * row + 1];
      }
      return outcome;
    };
  }
  std::vector<int64_t> rows;
  std::vector<std::vector<float>> given;
  std::vector<const void*> places;
  Result<bool> outcome = true;
};

Ends run(BatchRunner& runner, std::vector<std::pair<int, int>> frames) {
  Ends ends;
  BatchJobs jobs;
  for (const auto& [stream, number] : frames)
    jobs.push_back(
        numbered(stream, number, [&](NumberedJob::End end) { ends.push_back(std::move(end)); }));
  runner.run(jobs);
  return ends;
}

TEST(BatchRunner, EachFrameGetsItsPartOfTheOutputs) {
  Model model;
  BatchRunner runner(two_outputs(3), {}, 0ns, model.invoke());
  const auto ends = run(runner, {{1, 7}, {2, 8}, {1, 9}});
  EXPECT_EQ(model.given, (std::vector<std::vector<float>>{{1, 7, 2, 8, 1, 9}}));
  ASSERT_EQ(ends.size(), 3u);
  EXPECT_EQ(ends[1].job, (Numbered{2, 8}));
  EXPECT_EQ(ends[0].outputs, (std::vector<std::vector<float>>{{10, 70}, {8}}));
  EXPECT_EQ(ends[1].outputs, (std::vector<std::vector<float>>{{20, 80}, {10}}));
  EXPECT_EQ(ends[2].outputs, (std::vector<std::vector<float>>{{10, 90}, {10}}));
  EXPECT_EQ(ends[0].run.number, 1u);
  EXPECT_EQ(ends[2].run.frames, 3u);
  EXPECT_EQ(ends[0].copied, 2 * sizeof(float)) << "into the batch; outputs are not copied";
  EXPECT_EQ(
      static_cast<const float*>(ends[1].places[0]) - static_cast<const float*>(ends[0].places[0]),
      2)
      << "parts of one block";
}

// Ends before the batch, because its client has gone.
class UselessJob final : public BatchJob {
 public:
  explicit UselessJob(int* ended) : ended_(ended) {}
  std::span<const weir_tensor> inputs() const override { return {}; }
  bool end_if_useless() override { return ++*ended_ > 0; }
  void done(const BatchRun&, std::span<const weir_tensor>, const std::shared_ptr<void>&,
            uint64_t) override {
    ADD_FAILURE() << "it has ended";
  }
  void failed(const Error&) override { ADD_FAILURE() << "it has ended"; }
  void dropped(const BatchRun&) override { ADD_FAILURE() << "it has ended"; }

 private:
  int* ended_;
};

TEST(BatchRunner, RunsWithoutFramesWhoseClientHasGone) {
  Model model;
  BatchRunner runner(two_outputs(3), {}, 0ns, model.invoke());
  int useless = 0;
  Ends ends;
  BatchJobs jobs;
  jobs.push_back(std::make_unique<UselessJob>(&useless));
  jobs.push_back(numbered(1, 7, [&](NumberedJob::End end) { ends.push_back(std::move(end)); }));
  jobs.push_back(std::make_unique<UselessJob>(&useless));
  runner.run(jobs);
  EXPECT_EQ(useless, 2);
  ASSERT_EQ(ends.size(), 1u);
  EXPECT_EQ(ends[0].outputs, (std::vector<std::vector<float>>{{10, 70}, {8}}));
  EXPECT_EQ(ends[0].run.frames, 1u);
}

TEST(BatchRunner, DoesNotInvokeWhenAllClientsHaveGone) {
  Model model;
  BatchRunner runner(two_outputs(2), {}, 0ns, model.invoke());
  int useless = 0;
  BatchJobs jobs;
  jobs.push_back(std::make_unique<UselessJob>(&useless));
  runner.run(jobs);
  EXPECT_EQ(useless, 1);
  EXPECT_TRUE(model.given.empty());
}

// Runs a batch of frames that expire at these times, which a server answers if `server` is not
// empty. `given`: the time of the batch.
Ends run_expiring(const std::vector<int64_t>& times, const std::string& server, int64_t* given) {
  BatchRunner runner(two_outputs(times.size()), {}, 0ns,
                     [&](const weir_frame& in, weir_frame&, InvokeEnd* end) -> Result<bool> {
                       *given = in.expires;
                       end->answered_by = server;
                       return true;
                     });
  Ends ends;
  BatchJobs jobs;
  for (const int64_t time : times) {
    auto job = std::make_unique<NumberedJob>(
        Numbered{1, 1}, std::vector<float>{1, 2},
        [&ends](NumberedJob::End end) { ends.push_back(std::move(end)); });
    job->expires_at(time);
    jobs.push_back(std::move(job));
  }
  runner.run(jobs);
  return ends;
}

TEST(BatchRunner, ABatchExpiresWithTheLastOfItsFrames) {
  int64_t given = -1;
  for (const auto& end : run_expiring({5, 9, 7}, "", &given))
    EXPECT_FALSE(end.dropped) << "an engine on this machine may be late";
  EXPECT_EQ(given, 9);
  run_expiring({5, 0, 7}, "", &given);
  EXPECT_EQ(given, 0) << "one frame never expires";
}

TEST(BatchRunner, DropsAFrameForWhichAServerIsLate) {
  int64_t given = 0;
  const auto ends = run_expiring({1, INT64_MAX, 0}, "server", &given);
  ASSERT_EQ(ends.size(), 3u);
  EXPECT_TRUE(ends[0].dropped);
  EXPECT_EQ(ends[0].run.end.reason, WEIR_RESULT_LATE);
  for (size_t i = 1; i < 3; ++i) {
    EXPECT_FALSE(ends[i].dropped) << i;
    EXPECT_EQ(ends[i].run.end.reason, 0) << i;
  }
}

TEST(BatchRunner, OutputsLiveUntilTheLastReferenceIsReleased) {
  Model model;
  BatchRunner runner(two_outputs(2), {}, 0ns, model.invoke());
  const auto kept = run(runner, {{1, 1}, {2, 2}});
  for (int i = 0; i < 10; ++i) run(runner, {{5, 5}, {6, 6}});
  EXPECT_EQ(*static_cast<const float*>(kept[0].places[0]), 10.0f);
  const void* const first = run(runner, {{7, 7}, {8, 8}})[0].places[0];
  EXPECT_EQ(run(runner, {{7, 7}, {8, 8}})[0].places[0], first) << "memory is used again";
}

TEST(BatchRunner, AFixedBatchIsPaddedWithItsLastFrame) {
  Model model;
  BatchRunner runner(two_outputs(4, true), {}, 0ns, model.invoke());
  const auto ends = run(runner, {{1, 7}, {2, 8}});
  EXPECT_EQ(model.given, (std::vector<std::vector<float>>{{1, 7, 2, 8, 2, 8, 2, 8}}));
  ASSERT_EQ(ends.size(), 2u) << "what was filled in has no stream";
  EXPECT_EQ(ends[1].outputs[0], (std::vector<float>{20, 80}));
  EXPECT_EQ(ends[1].run.frames, 2u);
  EXPECT_EQ(ends[1].copied, 2 * sizeof(float));
}

TEST(BatchRunner, ReshapesOrPadsByWhatEachCosts) {
  const auto open = two_outputs(4);
  EXPECT_EQ(frames_to_run(3, two_outputs(4, true), 0ns, 1h), 4u) << "fixed";
  EXPECT_EQ(frames_to_run(3, open, 0ns, std::nullopt), 4u) << "no full batch ran yet";
  EXPECT_EQ(frames_to_run(3, open, 1us, 4us), 4u) << "2 us to and fro, 1 us for what is missing";
  EXPECT_EQ(frames_to_run(1, open, 1us, 4us), 1u) << "3 us for what is missing";
  EXPECT_EQ(frames_to_run(4, open, 1ns, 1h), 4u);
}

TEST(BatchRunner, AnOpenBatchIsRunAtItsSizeWhereThatIsCheap) {
  Model model;
  BatchRunner runner(two_outputs(3), {}, 0ns, model.invoke());
  run(runner, {{1, 1}});
  run(runner, {{1, 1}, {1, 2}, {1, 3}});
  const auto ends = run(runner, {{4, 5}});
  EXPECT_EQ(model.rows, (std::vector<int64_t>{3, 3, 1}));
  EXPECT_EQ(model.given[2], (std::vector<float>{4, 5}));
  EXPECT_EQ(ends[0].outputs[1], (std::vector<float>{9}));
  EXPECT_EQ(ends[0].copied, 0u) << "one frame is read where it is";
}

TEST(BatchRunner, OneFrameIsCopiedIfTheModelNeedsDifferentMemory) {
  Model model;
  BatchRunner runner(two_outputs(2), {4096, 16}, 0ns, model.invoke());
  run(runner, {{1, 1}, {1, 2}});
  const auto ends = run(runner, {{4, 5}});
  EXPECT_EQ(model.rows, (std::vector<int64_t>{2, 1}));
  EXPECT_EQ(reinterpret_cast<uintptr_t>(model.places[1]) % 4096, 0u);
  EXPECT_EQ(ends[0].copied, 2 * sizeof(float));
}

TEST(BatchRunner, AFailureGoesToEveryFrameOfTheBatch) {
  Model model;
  model.outcome = Error{.code = Code::INVOKE_FAILED, .what = "ordered to fail"};
  BatchRunner runner(two_outputs(2), {}, 0ns, model.invoke());
  const auto ends = run(runner, {{1, 1}, {2, 1}});
  ASSERT_EQ(ends.size(), 2u);
  for (const auto& end : ends) {
    ASSERT_TRUE(end.error);
    EXPECT_EQ(end.error->what, "ordered to fail");
  }
  model.outcome = true;
  EXPECT_FALSE(run(runner, {{1, 2}, {2, 2}})[0].error) << "the next batch is run";
}

TEST(BatchRunner, ADroppedBatchDropsEveryFrame) {
  Model model;
  model.outcome = false;
  BatchRunner runner(two_outputs(2), {}, 0ns, model.invoke());
  const auto ends = run(runner, {{1, 1}, {2, 1}});
  ASSERT_EQ(ends.size(), 2u);
  EXPECT_TRUE(ends[0].dropped && ends[1].dropped);
}

TEST(BatchRunner, AnExceptionFailsEveryFrame) {
  BatchRunner runner(two_outputs(2), {}, 0ns,
                     [](const weir_frame&, weir_frame&, InvokeEnd*) -> Result<bool> {
                       throw std::runtime_error("thrown in an engine");
                     });
  const auto ends = run(runner, {{1, 1}, {2, 1}});
  ASSERT_EQ(ends.size(), 2u);
  EXPECT_EQ(ends[1].error->offered, "thrown in an engine");
}

TEST(BatchRunner, AFrameOfADifferentSizeFailsAlone) {
  Model model;
  BatchRunner runner(two_outputs(3, true), {}, 0ns, model.invoke());
  Ends ends;
  const auto note = [&](NumberedJob::End end) { ends.push_back(std::move(end)); };
  BatchJobs jobs;
  jobs.push_back(numbered(1, 1, note));
  jobs.push_back(std::make_unique<NumberedJob>(Numbered{2, 1}, std::vector<float>{1, 2, 3}, note));
  runner.run(jobs);
  ASSERT_EQ(ends.size(), 2u);
  EXPECT_EQ(ends[0].error->code, Code::FRAME_SIZE);
  EXPECT_EQ(ends[0].error->offered, "1 tensors, the first of 12 bytes");
  EXPECT_EQ(ends[0].error->needed, "1 tensors, the first of 8 bytes");
  EXPECT_EQ(ends[1].outputs[0], (std::vector<float>{10, 10}));
}

// Axis 1: the rows of all frames are interleaved. x [2, n, 1] -> y [2, n, 1] = x + 1.
TEST(BatchRunner, AnInnerAxisIsInterleavedAndSplit) {
  std::vector<float> given;
  BatchRunner runner({{{1}, {1}, false}, 2, {tensor({2, 1, 1})}, {tensor({2, 1, 1})}}, {}, 0ns,
                     [&](const weir_frame& in, weir_frame& out, InvokeEnd*) -> Result<bool> {
                       const auto* x = static_cast<const float*>(in.tensors[0].data);
                       auto* y = static_cast<float*>(out.tensors[0].data);
                       given.assign(x, x + 4);
                       for (int i = 0; i < 4; ++i) y[i] = x[i] + 1;
                       return true;
                     });
  const auto ends = run(runner, {{1, 2}, {3, 4}});
  EXPECT_EQ(given, (std::vector<float>{1, 3, 2, 4}));
  EXPECT_EQ(ends[0].outputs[0], (std::vector<float>{2, 3}));
  EXPECT_EQ(ends[1].outputs[0], (std::vector<float>{4, 5}));
  EXPECT_EQ(ends[1].copied, 4 * sizeof(float)) << "in and out";
}

}  // namespace batch_runner_test
}  // namespace weir::infer
