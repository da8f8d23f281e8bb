// Tests that filters of one model share its batches, and that the model changes between batches.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/batch/model_batches.hpp"

#include <gtest/gtest.h>

#include "core/infer/model/sum_engine_test_support.hpp"
#include "core/infer/queue/numbered_job_test_support.hpp"

namespace weir::infer {
namespace model_batches_test {

using namespace std::chrono_literals;
using sum_engine::floats;
using sum_engine::rules;
using sum_engine::seen;

class ModelBatchesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    rules = {};
    seen.open_models = seen.open_sessions = seen.clashes = 0;
    engine_ = sum_engine::make_engine();
  }
  void TearDown() override {
    EXPECT_EQ(seen.open_models, 0);
    EXPECT_EQ(seen.open_sessions, 0);
    EXPECT_EQ(seen.clashes, 0);
  }
  ModelConfig source(const std::string& text) {
    ModelConfig out;
    out.engine = &engine_;
    out.options.paths = {files_.write(text + ".sum", text)};
    return out;
  }
  std::shared_ptr<SharedModel> shared(const std::string& text) {
    return std::make_shared<SharedModel>("k", source(text));
  }
  static Result<ModelBatch> join(const std::shared_ptr<SharedModel>& model, int64_t rows = 1) {
    return join_model_batch(model, {{0}, {0}, false}, 2, {floats(rows, 2)});
  }
  // The first output of one frame {stream, number} that runs alone.
  static std::vector<float> run(const ModelBatch& batch, int stream, int number) {
    std::mutex mutex;
    std::condition_variable changed;
    std::optional<NumberedJob::End> ended;
    const auto joined = BatchGroup::join(batch.group, 0ns);
    joined->add(numbered(stream, number, [&](NumberedJob::End end) {
      std::lock_guard lock(mutex);
      ended = std::move(end);
      changed.notify_all();
    }));
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return ended.has_value(); });
    return ended->outputs.empty() ? std::vector<float>{} : ended->outputs[0];
  }

  weir_engine engine_{};
  sum_engine::Files files_;
};

TEST_F(ModelBatchesTest, TheSameFramesAreOneGroup) {
  const auto model = shared("1 2");
  const auto a = join(model), b = join(model), c = join(model, 3);
  ASSERT_TRUE(a && b && c);
  EXPECT_EQ(a->group, b->group);
  EXPECT_NE(a->group, c->group);
  EXPECT_EQ(a->outputs.at(0).shape, (std::vector<int64_t>{1, 2}));
  EXPECT_EQ(c->outputs.at(0).shape, (std::vector<int64_t>{3, 2}));
  EXPECT_EQ(seen.open_sessions, 2) << "one for each group";
  EXPECT_EQ(run(*a, 4, 5), (std::vector<float>{5, 6}));
}

TEST_F(ModelBatchesTest, TheModelIsReplacedBetweenBatches) {
  const auto model = shared("1 2");
  const auto batch = join(model);
  ASSERT_TRUE(batch);
  EXPECT_EQ(run(*batch, 4, 5), (std::vector<float>{5, 6}));
  ASSERT_TRUE(model->replace(source("10 2")));
  EXPECT_EQ(run(*batch, 4, 5), (std::vector<float>{14, 15}));
  const auto differs = model->replace(source("10 3"));
  ASSERT_FALSE(differs);
  EXPECT_EQ(differs.error().code, Code::MODEL_DIFFERS);
  EXPECT_EQ(run(*batch, 4, 5), (std::vector<float>{14, 15}));
}

TEST_F(ModelBatchesTest, TheEnginesErrorIsPassedOn) {
  const auto batch = join(std::make_shared<SharedModel>("k", source("no numbers")));
  ASSERT_FALSE(batch);
  EXPECT_EQ(batch.error().code, Code::MODEL_INVALID);
}

TEST_F(ModelBatchesTest, AGroupAloneKeepsTheModelOpen) {
  auto model = shared("1 2");
  auto batch = join(model);
  ASSERT_TRUE(batch);
  const std::weak_ptr<SharedModel> seen_model = model;
  model.reset();
  EXPECT_FALSE(seen_model.expired());
  EXPECT_EQ(run(*batch, 1, 1), (std::vector<float>{2, 2}));
  batch = Error{};
  EXPECT_TRUE(seen_model.expired());
}

}  // namespace model_batches_test
}  // namespace weir::infer
