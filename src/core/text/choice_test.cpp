// Values that are not allowed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/choice.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace weir {
namespace choice_test {

const std::vector<std::string> kFits{"auto", "stretch", "letterbox"};

TEST(Choice, ListsTheChoicesAndTheNearestOne) {
  EXPECT_EQ(not_one_of("no such fit", "leterbox", kFits).message(),
            "WEIR-1004: no such fit\n  offered: leterbox\n"
            "  needed: one of: auto, stretch, letterbox\n"
            "  first difference: did you mean letterbox?");
}

TEST(Choice, SuggestsNothingIfNoChoiceIsNear) {
  EXPECT_EQ(not_one_of("no such fit", "crop", kFits).difference, "");
  EXPECT_EQ(not_one_of("no such fit", "crop", {}).needed, "one of: none");
}

}  // namespace choice_test
}  // namespace weir
