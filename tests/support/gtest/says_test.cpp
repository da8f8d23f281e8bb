// Tests the failure messages of these macros.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "says.hpp"

#include <gtest/gtest-spi.h>

#include <deque>

namespace says_test {

// Messages that are consumed by reading, like those of a bus.
class Messages {
 public:
  std::string next() {
    if (left_.empty()) return "";
    std::string first = left_.front();
    left_.pop_front();
    return first;
  }

 private:
  std::deque<std::string> left_{"WEIR-3006: too hot\n  fix: wait", "WEIR-2004: too short"};
};

TEST(ExpectSays, FindsTextAnywhere) {
  Messages messages;
  EXPECT_SAYS(messages.next(), "too hot\n");
  EXPECT_SAYS(messages.next(), std::string("WEIR-2004"));
}

TEST(ExpectSays, ShowsTheWholeTextAndTheExpectedPart) {
  Messages one;
  EXPECT_NONFATAL_FAILURE(EXPECT_SAYS(one.next(), "too cold"), "WEIR-3006: too hot\n  fix: wait");
  EXPECT_SAYS(one.next(), "too short") << "no message is read twice";
  Messages other;
  EXPECT_NONFATAL_FAILURE(EXPECT_SAYS(other.next(), "too cold"), "\"too cold\"");
}

TEST(ExpectLacks, FailsIfTheTextIsPresent) {
  Messages messages;
  EXPECT_NONFATAL_FAILURE(EXPECT_LACKS(messages.next(), "fix:"), "WEIR-3006: too hot");
  EXPECT_LACKS(messages.next(), "fix:");
}

}  // namespace says_test
