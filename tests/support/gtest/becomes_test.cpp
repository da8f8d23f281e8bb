// Tests that the waits of tests end.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "becomes.hpp"

#include <gtest/gtest-spi.h>

namespace becomes_test {

using namespace std::chrono_literals;

constexpr auto kNever = [] { return false; };

TEST(BecomesTrue, WaitsUntilItHolds) {
  int requested = 0;
  EXPECT_TRUE(becomes_true([&] { return ++requested == 3; }, "the third time"));
  EXPECT_EQ(requested, 3);
}

TEST(BecomesTrue, FailsTheTestAndReportsWhatIsMissing) {
  bool came = true;
  EXPECT_NONFATAL_FAILURE(came = becomes_true(kNever, "rain", 0s), "timed out waiting for rain");
  EXPECT_FALSE(came);
}

TEST(BecomesTrue, DescribesWhatIsMissingAfterTheWait) {
  int requested = 0;
  const auto counts = [&] { return ++requested < 0; };
  const auto name = [&] { return requested > 0 ? "what was requested" : "nothing yet"; };
  EXPECT_NONFATAL_FAILURE(EXPECT_FALSE(becomes_true(counts, name, 0s)),
                          "timed out waiting for what was requested");
}

}  // namespace becomes_test
