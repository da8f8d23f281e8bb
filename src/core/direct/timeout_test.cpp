// Tests models that do not finish in time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <array>
#include <future>
#include <thread>

#include "becomes.hpp"
#include "core/direct/direct_test_support.hpp"

namespace weir::direct {
namespace timeout_test {

using namespace std::chrono_literals;
using Values = std::vector<float>;

// Invokes block until the gate opens.
class TimeoutTest : public DirectTest {
 protected:
  void SetUp() override {
    DirectTest::SetUp();
    TestModel::invoke_body = [this, open = gate_.get_future().share()](In in, Out out) {
      open.wait();
      const bool filled = add_one(in, out);
      last_input_ = floats(in[0])[0];
      ++ended_;
      return filled;
    };
  }
  // Waits until the closed model is freed, which is after an invoke that timed out.
  static void wait_for_close() {
    EXPECT_TRUE(becomes_true([] { return TestModel::closed != 0; }, "the end of the model"));
  }
  std::promise<void> gate_;
  std::atomic<float> last_input_ = 0;
  std::atomic<int> ended_ = 0;
};

// A deadline of this length is beyond the range of the clock.
TEST_F(TimeoutTest, TheLongestLimitNeverExpires) {
  gate_.set_value();
  const auto model = open();
  for (const auto limit :
       {std::chrono::nanoseconds::max(), std::chrono::nanoseconds::max() - 1ns}) {
    model->set_limit(limit);
    const Values x{1, 2};
    const auto outcome = model->invoke(std::array{lend(x, {1, 2})});
    ASSERT_TRUE(outcome) << outcome.error().message();
    EXPECT_EQ(values(outcome->results), (Values{2, 3}));
  }
}

TEST_F(TimeoutTest, ReturnsTheSameResultWithinTheLimit) {
  gate_.set_value();
  const auto model = open();
  model->set_limit(1h);
  const Values x{1, 2};
  Values y(2);
  std::array into{lend(y)};
  const auto outcome = model->invoke(std::array{lend(x, {1, 2})}, into);
  ASSERT_TRUE(outcome) << outcome.error().message();
  EXPECT_EQ(values(outcome->results), (Values{2, 3}));
  EXPECT_EQ(y, (Values{2, 3}));
  const auto batch = model->invoke_batch(std::array{lend(x), lend(x)}, 2);
  ASSERT_TRUE(batch) << batch.error().message();
  EXPECT_EQ(values(batch->results), (Values{2, 3, 2, 3}));
}

TEST_F(TimeoutTest, IsUnusableUntilTheInvokeHasEnded) {
  const auto model = open();
  model->set_limit(1ms);
  const Values x{1, 2};
  EXPECT_REFUSED(model->invoke(std::array{lend(x, {1, 2})}), WORKER_TIMEOUT, "the model timed out");
  EXPECT_REFUSED(model->invoke(std::array{lend(x, {1, 2})}), WORKER_TIMEOUT,
                 "the model is still running an invoke that timed out");
  EXPECT_REFUSED(model->reshape({tensor_info("", WEIR_TYPE_END, {1, 2})}), WORKER_TIMEOUT,
                 "is still running");
  model->set_limit(0ns);
  EXPECT_REFUSED(model->invoke(std::array{lend(x, {1, 2})}), WORKER_TIMEOUT, "is still running");
  gate_.set_value();
  const auto succeeds = [&] {
    const auto outcome = model->invoke(std::array{lend(x, {1, 2})});
    if (outcome)
      EXPECT_EQ(values(outcome->results), (Values{2, 3}));
    else
      EXPECT_EQ(outcome.error().code, Code::WORKER_TIMEOUT);
    return outcome.has_value() || outcome.error().code != Code::WORKER_TIMEOUT;
  };
  EXPECT_TRUE(becomes_true(succeeds, "an answer of the model"));
  EXPECT_EQ(ended_, 2);
}

TEST_F(TimeoutTest, DoesNotAccessTheMemoryOfACallerThatTimedOut) {
  auto model = open();
  model->set_limit(1ms);
  {
    auto x = std::make_unique<Values>(Values{5, 6});
    auto y = std::make_unique<Values>(Values{0, 0});
    std::array into{lend(*y)};
    EXPECT_REFUSED(model->invoke(std::array{lend(*x, {1, 2})}, into), WORKER_TIMEOUT, "timed out");
    (*x)[0] = 99;
  }  // freed: AddressSanitizer reports later accesses
  model.reset();
  EXPECT_EQ(TestModel::closed, 0) << "the engine works in it";
  gate_.set_value();
  wait_for_close();
  EXPECT_EQ(ended_, 1);
  EXPECT_EQ(last_input_, 5) << "a copy, as it was when the call began";
}

TEST_F(TimeoutTest, CountsTheWaitForAnotherCall) {
  const auto model = open();
  const Values x{1, 2};
  std::promise<void> began;
  TestModel::invoke_body = [&, inner = TestModel::invoke_body](In in, Out out) {
    began.set_value();
    return inner(in, out);
  };
  std::jthread other([&] { EXPECT_TRUE(model->invoke(std::array{lend(x, {1, 2})})); });
  began.get_future().wait();
  model->set_limit(1ms);
  EXPECT_REFUSED(model->invoke(std::array{lend(x, {1, 2})}), WORKER_TIMEOUT,
                 "another call of the model did not return in time");
  gate_.set_value();
}

TEST_F(DirectTest, CallsOfManyThreadsWaitForEachOther) {
  const auto model = open();
  std::atomic<int> inside = 0, max = 0;
  TestModel::invoke_body = [&](In in, Out out) {
    max = std::max(max.load(), ++inside);
    const bool filled = add_one(in, out);
    --inside;
    return filled;
  };
  {
    std::vector<std::jthread> threads;
    for (float n = 0; n < 4; ++n)
      threads.emplace_back([&, n] {
        for (int i = 0; i < 50; ++i) {
          if (i == 25) model->set_limit(1h);
          const Values x{n, n};
          const auto outcome = model->invoke(std::array{lend(x, {1, 2})});
          ASSERT_TRUE(outcome) << outcome.error().message();
          EXPECT_EQ(values(outcome->results), (Values{n + 1, n + 1}));
        }
      });
  }
  EXPECT_EQ(max, 1);
}

}  // namespace timeout_test
}  // namespace weir::direct
