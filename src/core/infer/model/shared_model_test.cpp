// Tests shared models: replacing and suspending them with several users.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/model/shared_model.hpp"

#include <gtest/gtest.h>

#include "becomes.hpp"
#include "core/infer/model/sum_engine_test_support.hpp"
#include "says.hpp"

namespace weir::infer {
namespace shared_model_test {

using sum_engine::floats;
using sum_engine::rules;
using sum_engine::seen;

class SharedModelTest : public ::testing::Test {
 protected:
  void SetUp() override {
    rules = {};
    seen.opened = seen.closed = seen.sessions = seen.freed = seen.warmed = seen.slept = 0;
    seen.woken = seen.working = seen.max_working = seen.clashes = 0;
    seen.open_models = seen.open_sessions = 0;
    engine_ = sum_engine::make_engine();
  }
  void TearDown() override {
    EXPECT_EQ(seen.open_models, 0);
    EXPECT_EQ(seen.open_sessions, 0);
    EXPECT_EQ(seen.clashes, 0);
  }
  ModelConfig source(const std::string& path) {
    ModelConfig out;
    out.engine = &engine_;
    out.options.paths = {path};
    return out;
  }
  std::shared_ptr<SharedModel> shared(const std::string& path) {
    return std::make_shared<SharedModel>("k", source(path));
  }
  // The model's result for 0.
  static float run(ModelLease& use, size_t worker = 0) {
    auto frame = use.begin();
    if (!frame) {
      ADD_FAILURE() << frame.error().message();
      return -1;
    }
    return run(*frame, worker);
  }
  static float run(const ModelLease::Frame& frame, size_t worker = 0) {
    float x[4] = {}, y[4] = {};
    weir_tensor in_tensor{}, out_tensor{};
    in_tensor.data = x;
    out_tensor.data = y;
    in_tensor.bytes = out_tensor.bytes = sizeof x;
    weir_frame in{}, out{};
    in.n_tensors = out.n_tensors = 1;
    in.tensors = &in_tensor;
    out.tensors = &out_tensor;
    EXPECT_TRUE(frame.session(worker).invoke(in, out));
    return y[3];
  }

  sum_engine::Files files_;
  weir_engine engine_{};
};

TEST_F(SharedModelTest, OpensOnceAndGivesEachLeaseASession) {
  const auto model = shared(files_.write("a", "5 4"));
  {
    const auto first = ModelLease::create(model, 1), second = ModelLease::create(model, 1);
    ASSERT_TRUE(first && second);
    EXPECT_EQ(seen.opened, 1);
    EXPECT_EQ(seen.sessions, 2);
    EXPECT_EQ(model->users(), 2u);
    EXPECT_EQ(run(**first), 5);
    EXPECT_EQ(run(**second), 5);
  }
  EXPECT_EQ(model->users(), 0u);
  EXPECT_EQ(seen.closed, 1) << "the last user closes it";
  EXPECT_FALSE(model->model());
}

TEST_F(SharedModelTest, MakesAsManySessionsAsWorkersWantAndTheEngineAllows) {
  rules.max_sessions = 2;
  const auto model = shared(files_.write("a", "5 4"));
  const auto first = ModelLease::create(model, 4), second = ModelLease::create(model, 1);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(seen.opened, 2) << "once more for the workers that the first allows no session";
  EXPECT_EQ(seen.sessions, 4) << "the second use shares one";
  EXPECT_EQ(run(**second), 5);
  for (size_t worker = 0; worker < 4; ++worker) EXPECT_EQ(run(**first, worker), 5);
}

TEST_F(SharedModelTest, PassesOnTheEnginesErrorWhenAModelCannotBeOpened) {
  const auto gone = ModelLease::create(shared("/nowhere/a"), 1);
  ASSERT_FALSE(gone);
  EXPECT_EQ(gone.error().code, Code::MODEL_NOT_FOUND);
  const auto bad = ModelLease::create(shared(files_.write("a", "no model")), 1);
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error().code, Code::MODEL_INVALID);
}

TEST_F(SharedModelTest, ReplacesForAllUsersBetweenFrames) {
  const auto model = shared(files_.write("a", "5 4"));
  const auto first = ModelLease::create(model, 1), second = ModelLease::create(model, 2);
  ASSERT_TRUE(first && second);
  ASSERT_TRUE((*first)->resolve({floats(1, 4)}));
  ASSERT_TRUE(model->replace(source(files_.write("b", "7 4"))));
  EXPECT_EQ(run(**first), 7);
  EXPECT_EQ(run(**second), 7);
  EXPECT_EQ(run(**second, 1), 7);
  EXPECT_EQ(seen.closed, 1) << "the old one is closed";
  EXPECT_EQ(model->reloads(), 1u);
  EXPECT_SAYS(model->source().to_string(), "/b framework=sum");
}

TEST_F(SharedModelTest, AModelThatLeavesItsTensorsOpenReplacesOneThatDoesNot) {
  const auto model = shared(files_.write("a", "5 4"));
  const auto use = ModelLease::create(model, 1);
  ASSERT_TRUE(use);
  ASSERT_TRUE((*use)->resolve({floats(1, 4)}));
  const auto status = model->replace(source(files_.write("b", "7 0")));
  ASSERT_TRUE(status) << status.error().message();
  EXPECT_EQ(run(**use), 7);
}

TEST_F(SharedModelTest, AFrameKeepsTheModelThatItStartedWith) {
  const auto model = shared(files_.write("a", "5 4"));
  const auto use = ModelLease::create(model, 1);
  ASSERT_TRUE(use);
  auto old_frame = std::make_unique<ModelLease::Frame>(*(*use)->begin());
  const auto path = files_.write("b", "7 4");
  std::thread loader([&] { EXPECT_TRUE(model->replace(source(path))); });
  EXPECT_TRUE(becomes_true([&] { return model->reloads() > 0; }, "the other model"));
  EXPECT_EQ(run(**use), 7) << "a frame that begins now";
  EXPECT_EQ(run(*old_frame), 5) << "a frame that began before";
  old_frame.reset();
  loader.join();
  EXPECT_EQ(seen.closed, 1);
}

TEST_F(SharedModelTest, KeepsTheOldModelWhenTheNewOneDoesNotFit) {
  const auto a = files_.write("a", "5 4");
  const auto model = shared(a);
  const auto use = ModelLease::create(model, 1);
  ASSERT_TRUE(use);
  const auto wide = files_.write("b", "7 8");
  const auto status = model->replace(source(wide));
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, Code::MODEL_DIFFERS);
  const auto text = status.error().message();
  EXPECT_SAYS(text, "WEIR-3012");
  EXPECT_SAYS(text, "offered: " + wide + ": in 1 tensor: float32 8:?; out 1 tensor: float32 8:?");
  EXPECT_SAYS(text, "needed: " + a + ": in 1 tensor: float32 4:?; out 1 tensor: float32 4:?");
  EXPECT_SAYS(text, "first difference: input 0 is float32 8:?, needed is float32 4:?");
  EXPECT_EQ(run(**use), 5);
  EXPECT_EQ(model->reloads(), 0u);
  EXPECT_EQ(seen.open_models, 1);
}

TEST_F(SharedModelTest, KeepsTheOldModelWhenTheNewOneCannotBeOpened) {
  const auto model = shared(files_.write("a", "5 4"));
  const auto use = ModelLease::create(model, 1);
  ASSERT_TRUE(use);
  auto status = model->replace(source("/nowhere/b"));
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, Code::MODEL_NOT_FOUND);
  status = model->replace(source(files_.write("b", "rubbish")));
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, Code::MODEL_INVALID);
  EXPECT_EQ(run(**use), 5);
}

TEST_F(SharedModelTest, KeepsTheOldModelWhenTheNewOneFailsOnZeros) {
  rules.refused_add = 7;
  const auto model = shared(files_.write("a", "5 4"));
  const auto use = ModelLease::create(model, 1);
  ASSERT_TRUE(use);
  ASSERT_TRUE((*use)->resolve({floats(2, 4)}));
  const auto status = model->replace(source(files_.write("b", "7 4")));
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, Code::INVOKE_FAILED);
  EXPECT_EQ(run(**use), 5);
  EXPECT_EQ(seen.open_models, 1);
}

TEST_F(SharedModelTest, SuspendsSessionsIfTheEngineCan) {
  rules.can_sleep = true;
  engine_ = sum_engine::make_engine();
  const auto use = ModelLease::create(shared(files_.write("a", "5 4")), 2);
  ASSERT_TRUE(use);
  EXPECT_TRUE((*use)->suspend());
  EXPECT_TRUE((*use)->suspended());
  EXPECT_EQ(seen.slept, 2);
  EXPECT_EQ(seen.closed, 0);
  EXPECT_EQ(run(**use), 5);
  EXPECT_EQ(seen.woken, 2);
  EXPECT_FALSE((*use)->suspended());
}

TEST_F(SharedModelTest, ClosesTheModelIfTheEngineCannotSuspendAndReopensItForTheNextFrame) {
  for (const bool has_control : {true, false}) {
    rules.has_control = has_control;
    engine_ = sum_engine::make_engine();
    const auto use = ModelLease::create(shared(files_.write("a", "5 4")), 1);
    ASSERT_TRUE(use);
    ASSERT_TRUE((*use)->resolve({floats(1, 4)}));
    EXPECT_TRUE((*use)->suspend());
    EXPECT_EQ(seen.open_models, 0);
    EXPECT_TRUE((*use)->suspended());
    EXPECT_EQ(run(**use), 5);
    EXPECT_EQ(seen.open_models, 1);
  }
}

TEST_F(SharedModelTest, DoesNotSuspendWhileAFrameIsInProgress) {
  const auto use = ModelLease::create(shared(files_.write("a", "5 4")), 1);
  ASSERT_TRUE(use);
  {
    const auto frame = (*use)->begin();
    EXPECT_FALSE((*use)->suspend());
    EXPECT_EQ(run(*frame), 5);
  }
  EXPECT_TRUE((*use)->suspend());
}

TEST_F(SharedModelTest, ASuspendedLeaseLeavesTheModelToTheOthers) {
  const auto model = shared(files_.write("a", "5 4"));
  const auto first = ModelLease::create(model, 1), second = ModelLease::create(model, 1);
  ASSERT_TRUE(first && second);
  EXPECT_TRUE((*first)->suspend());
  EXPECT_EQ(seen.open_models, 1);
  EXPECT_EQ(seen.open_sessions, 1);
  EXPECT_EQ(run(**second), 5);
  EXPECT_EQ(run(**first), 5);
  EXPECT_EQ(seen.opened, 1);
}

TEST_F(SharedModelTest, ASuspendedLeaseResumesWithTheReplacedModel) {
  for (const bool can_sleep : {false, true}) {
    rules.can_sleep = can_sleep;
    const auto model = shared(files_.write("a", "5 4"));
    const auto use = ModelLease::create(model, 1);
    ASSERT_TRUE(use);
    EXPECT_TRUE((*use)->suspend());
    ASSERT_TRUE(model->replace(source(files_.write("b", "7 4"))));
    EXPECT_EQ(seen.open_models, 0) << "not needed yet";
    EXPECT_EQ(run(**use), 7);
  }
}

TEST_F(SharedModelTest, RejectsAFileThatChangedWhileTheModelWasClosed) {
  const auto path = files_.write("a", "5 4");
  const auto use = ModelLease::create(shared(path), 1);
  ASSERT_TRUE(use);
  EXPECT_TRUE((*use)->suspend());
  files_.write("a", "5 9");
  const auto frame = (*use)->begin();
  ASSERT_FALSE(frame);
  EXPECT_EQ(frame.error().code, Code::MODEL_DIFFERS);
  files_.write("a", "6 4");
  EXPECT_EQ(run(**use), 6);
}

TEST_F(SharedModelTest, KeepsAttachedObjectsUntilTheLastReferenceIsReleased) {
  struct Collector {
    int number;
  };
  const auto model = shared(files_.write("a", "5 4"));
  int made = 0;
  const auto make = [&made] { return std::make_shared<Collector>(Collector{++made}); };
  auto first = model->attached<Collector>(make), second = model->attached<Collector>(make);
  EXPECT_EQ(first, second);
  EXPECT_EQ(made, 1);
  first.reset();
  second.reset();
  EXPECT_EQ(model->attached<Collector>(make)->number, 2);
}

}  // namespace shared_model_test
}  // namespace weir::infer
