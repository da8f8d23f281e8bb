// What tests ask of an error's words. A failure shows the whole text, which is read once.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gtest/gtest.h>

#include <string>

// A text has these words in it.
#define EXPECT_SAYS(text, words) EXPECT_PRED_FORMAT2(::testing::IsSubstring, words, text)

// A text has these words nowhere.
#define EXPECT_LACKS(text, words) EXPECT_PRED_FORMAT2(::testing::IsNotSubstring, words, text)

// A Result is an error of this code with these words.
#define EXPECT_REFUSED(result, expected_code, words)                                     \
  do {                                                                                   \
    const auto& said_ = (result);                                                        \
    ASSERT_FALSE(said_);                                                                 \
    EXPECT_EQ(said_.error().code, weir::Code::expected_code) << said_.error().message(); \
    EXPECT_SAYS(said_.error().message(), words);                                         \
  } while (false)
