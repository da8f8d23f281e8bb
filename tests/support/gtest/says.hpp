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
#define EXPECT_REFUSED(result, expected_code, words)                                         \
  do {                                                                                       \
    const auto& result_ = (result);                                                          \
    ASSERT_FALSE(result_);                                                                   \
    EXPECT_EQ(result_.error().code, weir::Code::expected_code) << result_.error().message(); \
    EXPECT_SAYS(result_.error().message(), words);                                           \
  } while (false)
