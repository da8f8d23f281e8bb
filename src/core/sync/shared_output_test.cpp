// SharedOutput under threads: one input at a time, and a closed input never waits.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/sync/shared_output.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <future>

#include "becomes.hpp"

namespace weir::sync {
namespace shared_output_test {

using Output = SharedOutput<int>;
using Access = Output::Access;

class SharedOutputTest : public ::testing::Test {
 protected:
  SharedOutputTest() {
    output.open(1);
    output.open(2);
  }
  std::future<Access> acquire_later(int input) {
    const size_t before = output.waiting();
    auto access =
        std::async(std::launch::async, [=, this] { return output.acquire_as_active(input); });
    EXPECT_TRUE(becomes_true([&] { return output.waiting() == before + 1; }, "a waiting thread"));
    return access;
  }
  Output output;
};

TEST_F(SharedOutputTest, TheInputThatAcquiresBecomesActive) {
  EXPECT_EQ(output.active(), 0);
  EXPECT_EQ(output.acquire_as_active(1), Access::Switched);
  output.release();
  EXPECT_EQ(output.acquire_as_active(1), Access::Granted);
  output.release();
  EXPECT_EQ(output.acquire_as_active(2), Access::Switched);
  output.release();
  EXPECT_EQ(output.active(), 2);
}

TEST_F(SharedOutputTest, AnotherInputWaitsUntilTheOutputIsReleased) {
  EXPECT_EQ(output.acquire_as_active(1), Access::Switched);
  auto second = acquire_later(2);
  output.release();
  EXPECT_EQ(second.get(), Access::Switched);
  output.release();
}

TEST_F(SharedOutputTest, AnInputThatWaitsIsActiveAtOnce) {
  EXPECT_EQ(output.acquire_as_active(1), Access::Switched);
  auto second = acquire_later(2);
  EXPECT_EQ(output.active(), 2);
  output.close(2);
  EXPECT_EQ(second.get(), Access::Denied);
  EXPECT_EQ(output.active(), 1) << "nothing of input 2 waits any more";
  output.release();
  EXPECT_EQ(output.acquire_as_active(1), Access::Granted) << "input 2 sent nothing";
}

TEST_F(SharedOutputTest, InputsPushInTheOrderOfTheirArrival) {
  EXPECT_EQ(output.acquire_as_active(1), Access::Switched);
  std::vector<int> order;
  std::vector<std::future<void>> inputs;
  for (int input = 5; input > 1; --input) {
    output.open(input);
    const size_t before = output.waiting();
    inputs.push_back(std::async(std::launch::async, [&, input] {
      EXPECT_EQ(output.acquire_as_active(input), Access::Switched);
      order.push_back(input);
      output.release();
    }));
    EXPECT_TRUE(becomes_true([&] { return output.waiting() == before + 1; }, "a waiting thread"));
    EXPECT_EQ(output.active(), input) << "the one that arrived last";
  }
  output.release();
  for (auto& input : inputs) input.get();
  EXPECT_EQ(order, (std::vector{5, 4, 3, 2}));
  EXPECT_EQ(output.active(), 2);
}

TEST_F(SharedOutputTest, AnInputStaysActiveUntilAnotherOneArrives) {
  using namespace std::chrono_literals;
  constexpr auto kNever = [] { return false; };
  EXPECT_EQ(output.acquire_as_active(1), Access::Switched);
  output.release();
  EXPECT_TRUE(output.stays_active(1, 1ms, kNever));
  EXPECT_FALSE(output.stays_active(1, 60s, [] { return true; })) << "it is over";
  EXPECT_FALSE(output.stays_active(2, 60s, kNever)) << "it is not active";
  auto stays = std::async(std::launch::async, [&] { return output.stays_active(1, 60s, kNever); });
  EXPECT_EQ(output.acquire_as_active(2), Access::Switched);
  output.release();
  EXPECT_FALSE(stays.get());
  stays = std::async(std::launch::async, [&] { return output.stays_active(2, 60s, kNever); });
  output.close(2);
  EXPECT_FALSE(stays.get());
}

TEST_F(SharedOutputTest, ASkippedInputIsSwitchedToAgain) {
  EXPECT_EQ(output.acquire_as_active(1), Access::Switched);
  output.release();
  output.pass_over(2);
  EXPECT_EQ(output.acquire_as_active(1), Access::Granted) << "another one was skipped";
  output.release();
  output.pass_over(1);
  EXPECT_EQ(output.acquire_as_active(1), Access::Switched);
  output.release();
  EXPECT_EQ(output.acquire_as_active(1), Access::Granted);
  output.release();
}

TEST_F(SharedOutputTest, ClosingAnInputWakesItsThread) {
  EXPECT_EQ(output.acquire_as_active(1), Access::Switched);
  auto second = acquire_later(2);
  EXPECT_FALSE(output.close(2)) << "it waits";
  EXPECT_EQ(second.get(), Access::Denied);
  EXPECT_EQ(output.acquire_as_active(2), Access::Denied) << "until it is opened";
  output.release();
  output.open(2);
  EXPECT_EQ(output.acquire_as_active(2), Access::Switched);
  EXPECT_TRUE(output.close(2)) << "it uses the output";
  output.release();
  EXPECT_FALSE(output.close(2));
}

TEST_F(SharedOutputTest, AFlushWakesTheThreadOfItsInputOnly) {
  EXPECT_EQ(output.acquire_as_active(1), Access::Switched);
  output.open(3);
  auto second = acquire_later(2), third = acquire_later(3);
  EXPECT_FALSE(output.flush_start(2)) << "input 1 pushed last";
  EXPECT_EQ(second.get(), Access::Denied);
  EXPECT_EQ(output.waiting(), 1u);
  EXPECT_FALSE(output.flush_stop(2));
  output.release();
  EXPECT_EQ(third.get(), Access::Switched);
}

TEST_F(SharedOutputTest, OthersWaitWhileTheOutputFlushesForTheActiveInput) {
  EXPECT_EQ(output.acquire_as_active(1), Access::Switched);
  EXPECT_TRUE(output.flush_start(1));
  output.flush_sent();
  output.release();
  auto second = acquire_later(2);
  EXPECT_FALSE(output.flush_start(1)) << "it flushes already";
  EXPECT_TRUE(output.flush_stop(1));
  EXPECT_EQ(output.waiting(), 1u) << "until FLUSH_STOP was sent";
  output.flush_sent();
  EXPECT_EQ(second.get(), Access::Switched);
  output.release();
  EXPECT_FALSE(output.flush_stop(1));
}

TEST_F(SharedOutputTest, FlushStopIsSentAfterFlushStart) {
  EXPECT_EQ(output.acquire_as_active(1), Access::Switched);
  output.release();
  EXPECT_TRUE(output.flush_start(1));
  std::atomic<bool> start_was_sent = false;
  auto stop = std::async(std::launch::async, [&] {
    const bool due = output.flush_stop(1);
    EXPECT_TRUE(start_was_sent);
    return due;
  });
  start_was_sent = true;
  output.flush_sent();
  EXPECT_TRUE(stop.get());
}

TEST_F(SharedOutputTest, AnInputMayUseTheOutputWithoutBecomingActive) {
  EXPECT_TRUE(output.acquire(1));
  output.release();
  EXPECT_EQ(output.active(), 0);
  EXPECT_EQ(output.acquire_as_active(2), Access::Switched);
  auto first = std::async(std::launch::async, [&] { return output.acquire(1); });
  EXPECT_TRUE(becomes_true([&] { return output.waiting() == 1; }, "a waiting thread"));
  output.close(1);
  EXPECT_FALSE(first.get());
  EXPECT_EQ(output.active(), 2);
}

TEST_F(SharedOutputTest, RemovalReturnsWhetherTheInputWasActive) {
  EXPECT_EQ(output.acquire_as_active(1), Access::Switched);
  output.release();
  EXPECT_FALSE(output.remove(2));
  EXPECT_TRUE(output.remove(1));
  EXPECT_EQ(output.active(), 0);
  EXPECT_EQ(output.acquire_as_active(1), Access::Denied);
}

TEST_F(SharedOutputTest, AResetEndsAFlush) {
  EXPECT_EQ(output.acquire_as_active(1), Access::Switched);
  output.release();
  EXPECT_TRUE(output.flush_start(1));
  output.flush_sent();
  output.reset();
  EXPECT_EQ(output.active(), 0);
  EXPECT_EQ(output.acquire_as_active(2), Access::Switched);
}

// Inputs push, flush and close at random: never two at once, and all threads return.
TEST_F(SharedOutputTest, OneInputAtATimeUnderThreads) {
  constexpr int kInputs = 4, kRounds = 2000;
  std::atomic<int> users = 0, granted = 0;
  std::vector<std::thread> threads;
  for (int input = 1; input <= kInputs; ++input)
    threads.emplace_back([&, input] {
      for (int round = 0; round < kRounds; ++round) {
        output.open(input);
        if (output.acquire_as_active(input) != Access::Denied) {
          EXPECT_EQ(++users, 1);
          ++granted;
          --users;
          output.release();
        }
        if (round % 7 != input) continue;
        if (output.flush_start(input)) output.flush_sent();
        if (output.flush_stop(input)) output.flush_sent();
      }
      output.remove(input);
    });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(granted, kInputs * kRounds);
}

}  // namespace shared_output_test
}  // namespace weir::sync
