// Macros that check error texts. A failure prints the whole text, which is evaluated once.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gtest/gtest.h>

#include <string>

// The text contains these words.
#define EXPECT_SAYS(text, words) EXPECT_PRED_FORMAT2(::testing::IsSubstring, words, text)

// The text does not contain these words.
#define EXPECT_LACKS(text, words) EXPECT_PRED_FORMAT2(::testing::IsNotSubstring, words, text)

// The Result is an error with this code and these words.
#define EXPECT_REFUSED(result, expected_code, words)                                     \
  do {                                                                                   \
    const auto& said_ = (result);                                                        \
    ASSERT_FALSE(said_);                                                                 \
    EXPECT_EQ(said_.error().code, weir::Code::expected_code) << said_.error().message(); \
    EXPECT_SAYS(said_.error().message(), words);                                         \
  } while (false)
