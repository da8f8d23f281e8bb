// Tests how many models and sessions are created for each kind of engine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/model/worker_sessions.hpp"

#include <gtest/gtest.h>

#include <set>

#include "core/infer/module/engine_objects_test_support.hpp"
#include "says.hpp"

namespace weir::infer {
namespace worker_sessions_test {

weir_model_info the_info;
int models, opened, sessions, refused_model, threads_wanted;

weir_engine engine() {
  weir_engine e{};
  e.struct_size = sizeof e;
  e.name = "test";
  e.open = [](const weir_open* request, weir_model** out, weir_error*) -> int {
    threads_wanted = request->threads;
    if (opened == refused_model) return -WEIR_OUT_OF_MEMORY;
    *out = new weir_model{opened++};
    ++models;
    return WEIR_OK;
  };
  e.close = [](weir_model* model) {
    --models;
    delete model;
  };
  e.info = [](weir_model*, weir_model_info* out, weir_error*) -> int {
    *out = the_info;
    return WEIR_OK;
  };
  e.session_new = [](weir_model* model, const weir_option*, uint32_t, weir_session** out,
                     weir_error*) -> int {
    *out = new weir_session{model};
    ++sessions;
    return WEIR_OK;
  };
  e.session_free = [](weir_session* session) {
    --sessions;
    delete session;
  };
  return e;
}

class WorkerSessions : public testing::Test {
 protected:
  void SetUp() override {
    models = opened = sessions = threads_wanted = 0;
    refused_model = -1;
    the_info = {};
    options_.threads = 3;
    model_ = *Model::open(engine_, options_);
  }
  Result<std::vector<std::shared_ptr<Session>>> made(uint32_t max_sessions, uint32_t flags,
                                                     size_t workers) {
    the_info.max_sessions = max_sessions;
    the_info.flags = flags;
    model_ = *Model::open(engine_, options_);
    const auto model = std::move(model_);
    return worker_sessions(*model, workers);
  }
  const weir_engine engine_ = engine();
  OpenOptions options_;
  std::shared_ptr<Model> model_;
};

size_t different(const std::vector<std::shared_ptr<Session>>& all) {
  return std::set<std::shared_ptr<Session>>(all.begin(), all.end()).size();
}

TEST_F(WorkerSessions, GivesEachWorkerItsOwnOfOneModel) {
  const auto all = made(0, 0, 4);
  ASSERT_TRUE(all);
  EXPECT_EQ(different(*all), 4u);
  EXPECT_EQ(sessions, 4);
  EXPECT_EQ(models, 1);
}

TEST_F(WorkerSessions, SharesOneWhereTheEngineIsThreadSafe) {
  const auto all = made(1, WEIR_MODEL_THREAD_SAFE, 4);
  ASSERT_TRUE(all);
  EXPECT_EQ(all->size(), 4u);
  EXPECT_EQ(different(*all), 1u);
  EXPECT_EQ(models, 1);
}

TEST_F(WorkerSessions, OpensTheModelAgainIfItHasNoMoreSessions) {
  for (const auto& [max, expected] : {std::pair{1u, 5}, {2u, 3}, {4u, 2}, {5u, 1}}) {
    const auto all = made(max, 0, 5);
    ASSERT_TRUE(all);
    EXPECT_EQ(different(*all), 5u) << max;
    EXPECT_EQ(models, expected) << max;
    EXPECT_EQ(threads_wanted, 3) << "opened with the same options";
  }
}

TEST_F(WorkerSessions, ClosesModelsWithTheirLastSession) {
  auto all = made(1, 0, 3);
  ASSERT_TRUE(all);
  all->pop_back();
  EXPECT_EQ(models, 2);
  all->clear();
  EXPECT_EQ(models, 0);
  EXPECT_EQ(sessions, 0);
}

TEST_F(WorkerSessions, ReportsWhyTheModelCannotBeOpenedAgain) {
  refused_model = 3;  // one in SetUp(), two for the workers
  const auto all = made(1, 0, 3);
  ASSERT_FALSE(all);
  EXPECT_EQ(all.error().code, Code::OUT_OF_MEMORY);
  EXPECT_EQ(models, 0) << "and keeps nothing";
}

TEST_F(WorkerSessions, RejectsSeveralWorkersForAModelThatKeepsState) {
  const auto all = made(0, WEIR_MODEL_STATEFUL, 2);
  ASSERT_FALSE(all);
  EXPECT_EQ(all.error().code, Code::OPTION_VALUE);
  EXPECT_SAYS(all.error().message(), "keeps state from frame to frame");
  EXPECT_SAYS(all.error().message(), "offered: workers=2");
  EXPECT_TRUE(made(0, WEIR_MODEL_STATEFUL, 1));
}

}  // namespace worker_sessions_test
}  // namespace weir::infer
