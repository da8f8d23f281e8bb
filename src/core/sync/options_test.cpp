// Valid and invalid values of sync-mode and sync-option.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/sync/options.hpp"

#include <gtest/gtest.h>

#include "says.hpp"

namespace weir::sync {
namespace options_test {

TEST(SyncOptions, ParsesEachPolicyInAnyCase) {
  EXPECT_EQ(*parse_mode("nosync"), Mode::NoSync);
  EXPECT_EQ(*parse_mode("Slowest"), Mode::Slowest);
  EXPECT_EQ(*parse_mode("BASEPAD"), Mode::BasePad);
  EXPECT_EQ(*parse_mode(" refresh "), Mode::Refresh);
}

TEST(SyncOptions, AcceptsTheNamesOfTheFirstPublication) {
  EXPECT_EQ(*parse_mode("base"), Mode::BasePad);
  EXPECT_EQ(*parse_mode("fastest"), Mode::Refresh);
}

TEST(SyncOptions, AnOldNameIsReportedWithTheCurrentOne) {
  for (const auto& [word, today] : {std::pair{"base", "basepad"}, {" Fastest", "refresh"}}) {
    const auto reported = old_name_warning(word);
    ASSERT_TRUE(reported) << word;
    EXPECT_EQ(reported->code, Code::MODE_UNKNOWN);
    EXPECT_EQ(reported->offered, word);
    EXPECT_SAYS(
        reported->what,
        std::string("is an old name that NNStreamer 2.7 does not know; it is read as ") + today);
    EXPECT_EQ(reported->fix, std::string("sync-mode=") + today);
  }
  for (const char* word : {"basepad", "refresh", "slowest", "nosync", "fast", ""})
    EXPECT_FALSE(old_name_warning(word)) << word;
}

TEST(SyncOptions, ATypoIsReportedWithTheNearestName) {
  const auto mode = parse_mode("slowst");
  ASSERT_FALSE(mode);
  EXPECT_EQ(mode.error().code, Code::MODE_UNKNOWN);
  EXPECT_EQ(mode.error().offered, "slowst");
  EXPECT_EQ(mode.error().fix, "sync-mode=slowest");
  EXPECT_SAYS(mode.error().needed, "nosync, slowest, basepad or refresh");
  for (const char* unlike : {"", "quick"}) {
    ASSERT_FALSE(parse_mode(unlike));
    EXPECT_EQ(parse_mode(unlike).error().fix, "") << "no known value is similar";
  }
}

TEST(SyncOptions, EachModeRoundTrips) {
  for (const Mode mode : {Mode::NoSync, Mode::Slowest, Mode::BasePad, Mode::Refresh})
    EXPECT_EQ(*parse_mode(to_string(mode)), mode);
}

TEST(SyncOptions, TheBaseHasAPadAndADuration) {
  EXPECT_EQ(parse_base("")->pad, 0u);
  EXPECT_EQ(parse_base("")->duration, 2147483647u);
  EXPECT_EQ(parse_base("3")->pad, 3u);
  EXPECT_EQ(parse_base("3")->duration, 2147483647u);
  EXPECT_EQ(parse_base("1:33333333")->pad, 1u);
  EXPECT_EQ(parse_base("1:33333333")->duration, 33333333u);
  EXPECT_EQ(parse_base(" 1 : 0 ")->duration, 0u);
}

TEST(SyncOptions, ABadBaseIsReportedWithItsPlace) {
  for (const char* text : {"x", "-1", ":5", "1.5"}) {
    const auto base = parse_base(text);
    ASSERT_FALSE(base) << text;
    EXPECT_EQ(base.error().code, Code::OPTION_SYNTAX);
    EXPECT_EQ(base.error().difference, "at character 1:\n    " + std::string(text) + "\n    ^");
  }
  const auto base = parse_base("12:3ms");
  ASSERT_FALSE(base);
  EXPECT_EQ(base.error().difference, "at character 4:\n    12:3ms\n       ^");
  EXPECT_FALSE(parse_base("1:2:3"));
}

}  // namespace options_test
}  // namespace weir::sync
