// What tests ask of an error's words.
#pragma once
#include <gtest/gtest.h>

#include <string>

// A text has these words in it.
#define EXPECT_SAYS(text, words) EXPECT_NE((text).find(words), std::string::npos) << (text)

// A Result is an error of this code with these words.
#define EXPECT_REFUSED(result, expected_code, words)                                              \
  do {                                                                                            \
    const auto& said_ = (result);                                                                 \
    ASSERT_FALSE(said_);                                                                          \
    EXPECT_EQ(said_.error().code, weir::Code::expected_code) << said_.error().message();          \
    EXPECT_NE(said_.error().message().find(words), std::string::npos) << said_.error().message(); \
  } while (false)
