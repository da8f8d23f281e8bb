// Tests the delays between workers with artificial times.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/restart_backoff.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace weir::isolate {
namespace restart_backoff_test {

using namespace std::chrono_literals;

constexpr RestartBackoff::Clock::time_point kStart{1000s};

TEST(RestartBackoff, DoublesUpToTenSeconds) {
  RestartBackoff backoff;
  backoff.started(kStart);
  const std::vector<std::chrono::milliseconds> waits{0ms,    100ms,  200ms,  400ms,   800ms,
                                                     1600ms, 3200ms, 6400ms, 10000ms, 10000ms};
  for (const auto& wait : waits) EXPECT_EQ(backoff.ended(kStart + 1s), wait);
}

TEST(RestartBackoff, StartsAgainAfterAQuietTime) {
  RestartBackoff backoff;
  backoff.started(kStart);
  backoff.ended(kStart);
  EXPECT_EQ(backoff.ended(kStart), 100ms);
  backoff.started(kStart);
  EXPECT_EQ(backoff.ended(kStart + 9999ms), 200ms);
  backoff.started(kStart);
  EXPECT_EQ(backoff.ended(kStart + 10s), 0ms);
  EXPECT_EQ(backoff.ended(kStart), 100ms);
}

}  // namespace restart_backoff_test
}  // namespace weir::isolate
