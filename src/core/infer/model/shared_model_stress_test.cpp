// Stress tests of sharing, replacing and suspending, also run under ThreadSanitizer.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include "core/infer/model/model_table.hpp"
#include "core/infer/model/sum_engine_test_support.hpp"

namespace weir::infer {
namespace shared_model_stress_test {

using sum_engine::rules;
using sum_engine::seen;

class SharedModelStress : public ::testing::Test {
 protected:
  void SetUp() override {
    rules = {};
    seen.clashes = seen.open_models = seen.open_sessions = seen.opened = 0;
    seen.max_working = 0;
    engine_ = sum_engine::make_engine();
    for (int add = 1; add <= 2; ++add) {
      ModelConfig s;
      s.engine = &engine_;
      s.options.paths = {files_.write(std::to_string(add), std::to_string(add) + " 4")};
      sources_.push_back(s);
    }
  }
  void TearDown() override {
    EXPECT_EQ(seen.clashes, 0);
    EXPECT_EQ(seen.open_models, 0);
    EXPECT_EQ(seen.open_sessions, 0);
  }
  // The number that the model adds; checks that all elements agree.
  static float run(ModelLease& use, size_t worker) {
    auto frame = use.begin();
    EXPECT_TRUE(frame);
    std::vector<float> x(64), y(64);
    weir_tensor in_tensor{}, out_tensor{};
    in_tensor.data = x.data();
    out_tensor.data = y.data();
    in_tensor.bytes = out_tensor.bytes = x.size() * sizeof(float);
    weir_frame in{}, out{};
    in.tensors = &in_tensor;
    out.tensors = &out_tensor;
    EXPECT_TRUE(frame->session(worker).invoke(in, out));
    EXPECT_EQ(y, std::vector<float>(64, y[0]));
    return y[0];
  }

  sum_engine::Files files_;
  weir_engine engine_{};
  std::vector<ModelConfig> sources_;
};

TEST_F(SharedModelStress, EveryFrameHasOneModelAndTheSwitchIsExact) {
  const auto shared = std::make_shared<SharedModel>("k", sources_[0]);
  constexpr int kReloads = 100;
  std::vector<std::unique_ptr<ModelLease>> uses;
  for (int i = 0; i < 3; ++i) uses.push_back(*ModelLease::create(shared, 1));
  const auto own = *ModelLease::create(shared, 1);  // of this thread
  std::atomic<bool> stop{false};
  const auto in_place = [](uint64_t reloads) { return static_cast<float>(reloads % 2 + 1); };
  std::vector<std::thread> threads;
  for (auto& use : uses)
    threads.emplace_back([&] {
      while (!stop) {
        const uint64_t before = shared->reloads();
        const float add = run(*use, 0);
        const uint64_t after = shared->reloads();
        EXPECT_TRUE(add == 1 || add == 2);
        if (before == after) {
          EXPECT_EQ(add, in_place(before));
        }
      }
    });
  for (int i = 1; i <= kReloads; ++i) {
    ASSERT_TRUE(shared->replace(sources_[static_cast<size_t>(i % 2)]));
    EXPECT_EQ(run(*own, 0), in_place(static_cast<uint64_t>(i)));
  }
  stop = true;
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(shared->reloads(), static_cast<uint64_t>(kReloads));
}

TEST_F(SharedModelStress, ManyUsersOfOneSessionWaitForTheirTurn) {
  rules.max_sessions = 1;
  const auto shared = std::make_shared<SharedModel>("k", sources_[0]);
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&] {
      const auto use = ModelLease::create(shared, 1);
      ASSERT_TRUE(use);
      for (int n = 0; n < 500; ++n) EXPECT_EQ(run(**use, 0), 1);
    });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(seen.max_working, 1);
}

TEST_F(SharedModelStress, WorkersInvokeSessionsOfTheirOwnWhileModelsAreReplaced) {
  const auto shared = std::make_shared<SharedModel>("k", sources_[0]);
  const auto use = ModelLease::create(shared, 4);
  ASSERT_TRUE(use);
  std::vector<std::thread> threads;
  for (size_t i = 0; i < 4; ++i)
    threads.emplace_back([&, i] {
      for (int n = 0; n < 500; ++n) {
        const float add = run(**use, i);
        EXPECT_TRUE(add == 1 || add == 2);
      }
    });
  for (size_t i = 0; i < 20; ++i) EXPECT_TRUE(shared->replace(sources_[(i + 1) % 2]));
  for (auto& thread : threads) thread.join();
}

TEST_F(SharedModelStress, UsersJoinLeaveAndSuspendWhileModelsAreReplaced) {
  ModelTable table;
  std::atomic<bool> stop{false};
  std::vector<std::thread> threads;
  for (int i = 0; i < 3; ++i)
    threads.emplace_back([&, i] {
      for (int n = 0; n < 200; ++n) {
        const auto found = table.find("k", sources_[0]);
        const auto use = ModelLease::create(found.model, 1);
        ASSERT_TRUE(use);
        for (int k = 0; k < 5; ++k) {
          const float add = run(**use, 0);
          EXPECT_TRUE(add == 1 || add == 2);
          if (k % 2 == i % 2) (*use)->suspend();
        }
      }
    });
  std::thread loader([&] {
    for (size_t i = 0; !stop; ++i) {
      const auto found = table.find("k", sources_[i % 2]);
      const auto held = ModelLease::create(found.model, 1);
      ASSERT_TRUE(held);
      EXPECT_TRUE(found.model->replace(sources_[(i + 1) % 2]));
    }
  });
  for (auto& thread : threads) thread.join();
  stop = true;
  loader.join();
}

}  // namespace shared_model_stress_test
}  // namespace weir::infer
