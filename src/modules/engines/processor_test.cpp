// Counting cores.
#include "processor.hpp"

#include <gtest/gtest.h>
#include <sched.h>

#include <thread>

namespace weir::engine {
namespace {

TEST(UsableCores, AreBetweenOneAndTheProcessorsOfTheMachine) {
  EXPECT_GE(usable_cores(), 1);
  EXPECT_LE(usable_cores(), static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
}

TEST(UsableCores, FollowTheAffinityOfTheThread) {
  int found = 0;
  std::thread([&found] {
    cpu_set_t mask;
    ASSERT_EQ(sched_getaffinity(0, sizeof mask, &mask), 0);
    int first = 0;
    while (!CPU_ISSET(first, &mask)) ++first;
    CPU_ZERO(&mask);
    CPU_SET(first, &mask);
    ASSERT_EQ(sched_setaffinity(0, sizeof mask, &mask), 0);
    found = usable_cores();
  }).join();
  EXPECT_EQ(found, 1);
}

}  // namespace
}  // namespace weir::engine
