// Tests calls with a limit: those that end and those that time out.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/direct/call_thread.hpp"

#include <gtest/gtest.h>

#include <future>

namespace weir::direct {
namespace call_thread_test {

using namespace std::chrono_literals;

TEST(CallThread, RunsCallsOneAfterTheOther) {
  CallThread thread;
  int value = 0;
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(thread.run([&] { value += i; }, 1h));
  EXPECT_EQ(value, 4950);
}

TEST(CallThread, AbandonsACallAndContinues) {
  CallThread thread;
  std::promise<void> gate;
  std::promise<int> ended;
  EXPECT_FALSE(thread.run(
      [open = gate.get_future().share(), &ended] {
        open.wait();
        ended.set_value(1);
      },
      1ms));
  std::thread later([&] { gate.set_value(); });
  EXPECT_TRUE(thread.run([] {}, 1h)) << "it waits for the one before";
  EXPECT_EQ(ended.get_future().get(), 1);
  later.join();
}

TEST(CallThread, IgnoresTheEndOfAnAbandonedCall) {
  CallThread thread;
  std::promise<void> first, second;
  EXPECT_FALSE(thread.run([open = first.get_future().share()] { open.wait(); }, 1ms));
  std::promise<void> began;
  std::thread later([&] { first.set_value(); });
  EXPECT_FALSE(thread.run(
      [open = second.get_future().share(), &began] {
        began.set_value();
        open.wait();
      },
      50ms));
  began.get_future().wait();
  second.set_value();
  later.join();
}

TEST(CallThread, CanBeDestroyedDuringACall) {
  std::promise<void> gate;
  auto kept = std::make_shared<int>(7);
  std::promise<int> seen;
  {
    CallThread thread;
    EXPECT_FALSE(thread.run(
        [open = gate.get_future().share(), kept, &seen] {
          open.wait();
          seen.set_value(*kept);
        },
        1ms));
  }
  std::weak_ptr<int> watch = kept;
  kept.reset();
  EXPECT_FALSE(watch.expired()) << "the call owns it";
  gate.set_value();
  EXPECT_EQ(seen.get_future().get(), 7);
}

}  // namespace call_thread_test
}  // namespace weir::direct
