// Tests of the check for thread capacity.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "thread_limit.hpp"

#include <gtest/gtest.h>

#include <cstdio>

#include "out_of_memory_test_support.hpp"
#include "says.hpp"

namespace weir::engine {
namespace thread_limit_test {

TEST(ThreadLimit, SufficesForAFewThreads) {
  EXPECT_TRUE(check_thread_limit(0));
  EXPECT_TRUE(check_thread_limit(4));
}

TEST(ThreadLimit, IsMissingWithoutMemoryForStacks) {
  if (!can_limit_address_space()) GTEST_SKIP() << "the address space cannot be limited";
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        Status status = ok();
        {
          const engine_test::AddressSpaceLimit limit(uint64_t{20} << 20);  // room for two stacks
          status = check_thread_limit(64);
        }
        std::fprintf(stderr, "%s", status ? "started" : status.error().message().c_str());
        std::_Exit(check_thread_limit(2) ? 0 : 1);
      },
      testing::ExitedWithCode(0),
      "WEIR-9001: the system cannot start more threads for the engine(.|\n)* of 64(.|\n)*"
      "fix: custom=NumThreads:1");
}

}  // namespace thread_limit_test
}  // namespace weir::engine
