// Waits for a condition in tests, with a time limit.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <type_traits>

// Far more than a busy machine needs, even with a sanitizer, and less than the suite's limit for a
// program, so that a failed wait reports what it was waiting for.
inline constexpr std::chrono::seconds kMaxWait{60};

// Whether one of five attempts took less than `limit`, for what must not wait that long: a busy
// machine may delay some of them.
template <class Preparation, class Attempt>
[[nodiscard]] bool is_quick(const Preparation& prepare, const Attempt& attempt,
                            std::chrono::steady_clock::duration limit) {
  for (int i = 0; i < 5; ++i) {
    prepare();
    const auto began = std::chrono::steady_clock::now();
    attempt();
    if (std::chrono::steady_clock::now() - began < limit) return true;
  }
  return false;
}

// Whether `holds` became true; otherwise the test fails with `awaited`: a text, or a function that
// makes one after the wait.
template <class Condition, class Text>
[[nodiscard]] bool becomes_true(const Condition& holds, const Text& awaited,
                                std::chrono::steady_clock::duration longest = kMaxWait) {
  const auto end = std::chrono::steady_clock::now() + longest;
  // What is waited for may need each of the machine's few cores.
  constexpr std::chrono::microseconds kShortestPause{200}, kMaxPause{2000};
  for (auto pause = kShortestPause; !holds(); pause = std::min(2 * pause, kMaxPause)) {
    if (std::chrono::steady_clock::now() > end) {
      if constexpr (std::is_invocable_v<const Text&>)
        ADD_FAILURE() << "timed out waiting for " << awaited();
      else
        ADD_FAILURE() << "timed out waiting for " << awaited;
      return false;
    }
    std::this_thread::sleep_for(pause);
  }
  return true;
}
