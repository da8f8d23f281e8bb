// Text helpers: which input they accept and reject.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/text.hpp"

#include <gtest/gtest.h>

#include "weir/join.hpp"

namespace weir {
namespace text_test {

TEST(Text, StripsBlanksAtBothEndsOnly) {
  EXPECT_EQ(strip("  a b\t\n"), "a b");
  EXPECT_EQ(strip(" \t "), "");
}

TEST(Text, SplitsKeepingEmptyParts) {
  using Parts = std::vector<std::string_view>;
  EXPECT_EQ(split("a,,b.c", ",."), (Parts{"a", "", "b", "c"}));
  EXPECT_EQ(split("", ","), (Parts{""}));
  EXPECT_EQ(split("a:b:c", ":", 2), (Parts{"a", "b:c"}));
}

TEST(Text, ReadsWholeNumbersOnly) {
  EXPECT_EQ(parse_unsigned("18446744073709551615"), UINT64_MAX);
  EXPECT_EQ(parse_signed("+7"), 7);
  EXPECT_EQ(parse_signed("-9223372036854775808"), INT64_MIN);
  EXPECT_EQ(parse_double("+.5e1"), 5.0);
  for (const char* text : {"", "-1", "+1", "1 ", "0x1", "18446744073709551616", "1.0"})
    EXPECT_FALSE(parse_unsigned(text)) << text;
  for (const char* text : {"", "+-1", "++1", "1e3", "9223372036854775808"})
    EXPECT_FALSE(parse_signed(text)) << text;
  for (const char* text : {"", "inf", "nan", "1e999", "1,5", "+-1", "x"})
    EXPECT_FALSE(parse_double(text)) << text;
}

TEST(Text, FindsTheNearestText) {
  const std::vector<std::string> words{"tensorflow-lite", "onnxruntime"};
  EXPECT_EQ(nearest("tensorfow-lite", words), "tensorflow-lite");
  EXPECT_EQ(nearest("OnnxRuntme", words), "onnxruntime");
  EXPECT_EQ(nearest("caffe", words), "");
}

TEST(Text, AWordOfWhichEachLetterDiffersIsNotNear) {
  const std::vector<std::string> words{"m", "ab"};
  EXPECT_EQ(nearest("!", words), "");
  EXPECT_EQ(nearest("", words), "");
  EXPECT_EQ(nearest("M", words), "m");
  EXPECT_EQ(nearest("ac", words), "ab");
  EXPECT_EQ(nearest("cd", words), "");
}

TEST(Text, OfTwoNearWordsTheOneThatStartsTheSameWayIsNearest) {
  const std::vector<std::string> elements{"tensor_mux", "tensor_demux", "tensor_mix"};
  EXPECT_EQ(nearest("tensor_dmux", elements), "tensor_demux");
  EXPECT_EQ(nearest("tensor_mx", elements), "tensor_mux");  // the first of equals
}

TEST(Text, SwappedLettersAreOneTypingError) {
  const std::vector<std::string> layouts{"auto", "NHWC", "NCHW"};
  EXPECT_EQ(nearest("NHCW", layouts), "NHWC");  // both are one edit away; the first one wins
  EXPECT_EQ(nearest("ncwh", layouts), "NCHW");
  EXPECT_EQ(nearest("HNWC", layouts), "NHWC");
  EXPECT_EQ(nearest("CWHN", layouts), "");  // two edits away
  EXPECT_EQ(nearest("NC", layouts), "");
}

TEST(Text, ComparesWithoutCase) {
  EXPECT_TRUE(equal_ignoring_case("AuTo", "auto"));
  EXPECT_FALSE(equal_ignoring_case("auto", "aut"));
  EXPECT_EQ(lower("ABC-1"), "abc-1");
}

TEST(Text, TimesHaveHoursAndNanoseconds) {
  EXPECT_EQ(time_text(0), "0:00:00.000000000");
  EXPECT_EQ(time_text(3'723'000'000'001), "1:02:03.000000001");
  EXPECT_EQ(time_text(UINT64_MAX), "5124095:34:33.709551615");
}

TEST(Join, PutsTheSeparatorBetweenItems) {
  EXPECT_EQ(join(std::vector<std::string>{}, ", "), "");
  EXPECT_EQ(join(std::vector<std::string>{"", "a", ""}, ","), ",a,");
  EXPECT_EQ(join(std::vector<std::string_view>{"a", "bc"}, " or "), "a or bc");
  EXPECT_EQ(join(std::vector<int>{1, 2, 3}, ":", [](int n) { return std::to_string(n * n); }),
            "1:4:9");
}

}  // namespace text_test
}  // namespace weir
