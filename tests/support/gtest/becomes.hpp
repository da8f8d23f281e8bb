// What a test waits for: a condition, and no longer than anything of it may take.
#pragma once
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <thread>

// Far more than a busy machine takes, also under a sanitizer, and less than the suite gives a
// program: who waits in vain says for what.
inline constexpr std::chrono::seconds kLongestWait{60};

// Whether `holds` came true; otherwise the test fails with what `awaited` says.
template <class Condition, class Text>
[[nodiscard]] bool becomes_true(const Condition& holds, const Text& awaited) {
  const auto end = std::chrono::steady_clock::now() + kLongestWait;
  while (!holds()) {
    if (std::chrono::steady_clock::now() > end) {
      ADD_FAILURE() << "waited in vain for " << awaited();
      return false;
    }
    std::this_thread::yield();
  }
  return true;
}
