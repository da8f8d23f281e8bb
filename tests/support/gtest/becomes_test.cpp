// Tests that the waits of tests end.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "becomes.hpp"

#include <gtest/gtest-spi.h>

namespace {

using namespace std::chrono_literals;

constexpr auto kNever = [] { return false; };

TEST(BecomesTrue, WaitsUntilItHolds) {
  int asked = 0;
  EXPECT_TRUE(becomes_true([&] { return ++asked == 3; }, "the third time"));
  EXPECT_EQ(asked, 3);
}

TEST(BecomesTrue, FailsTheTestAndReportsWhatIsMissing) {
  bool came = true;
  EXPECT_NONFATAL_FAILURE(came = becomes_true(kNever, "rain", 0s), "waited in vain for rain");
  EXPECT_FALSE(came);
}

TEST(BecomesTrue, DescribesWhatIsMissingAfterTheWait) {
  int asked = 0;
  const auto counts = [&] { return ++asked < 0; };
  const auto name = [&] { return asked > 0 ? "what was asked for" : "nothing yet"; };
  EXPECT_NONFATAL_FAILURE(EXPECT_FALSE(becomes_true(counts, name, 0s)),
                          "waited in vain for what was asked for");
}

}  // namespace
