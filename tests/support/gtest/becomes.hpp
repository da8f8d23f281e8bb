// What a test waits for: a condition, and no longer than anything of it may take.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gtest/gtest.h>

#include <chrono>
#include <thread>
#include <type_traits>

// Far more than a busy machine takes, also under a sanitizer, and less than the suite gives a
// program: who waits in vain says for what.
inline constexpr std::chrono::seconds kLongestWait{60};

// Whether `holds` came true; otherwise the test fails with what was `awaited`: a text, or a
// function that makes one when the wait is over.
template <class Condition, class Text>
[[nodiscard]] bool becomes_true(const Condition& holds, const Text& awaited,
                                std::chrono::steady_clock::duration longest = kLongestWait) {
  const auto end = std::chrono::steady_clock::now() + longest;
  while (!holds()) {
    if (std::chrono::steady_clock::now() > end) {
      if constexpr (std::is_invocable_v<const Text&>)
        ADD_FAILURE() << "waited in vain for " << awaited();
      else
        ADD_FAILURE() << "waited in vain for " << awaited;
      return false;
    }
    std::this_thread::yield();
  }
  return true;
}
