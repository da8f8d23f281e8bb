// FilePattern: names of numbered files as printf writes them, and patterns that are none.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/dataset/file_pattern.hpp"

#include <gtest/gtest.h>

#include <cstdio>

#include "says.hpp"

namespace weir::dataset {
namespace file_pattern_test {

// The same name as printf writes; a macro, because the compiler checks literals only.
#define EXPECT_NAMES_LIKE_PRINTF(pattern)                                       \
  for (const uint64_t index : {0u, 7u, 42u, 99999u, 2147483647u}) {             \
    char expected[128];                                                         \
    std::snprintf(expected, sizeof expected, pattern, static_cast<int>(index)); \
    EXPECT_EQ(FilePattern::parse(pattern)->name(index), expected);              \
  }

TEST(FilePattern, NamesFilesAsPrintfDoes) {
  EXPECT_NAMES_LIKE_PRINTF("img_%02d.png");
  EXPECT_NAMES_LIKE_PRINTF("%d");
  EXPECT_NAMES_LIKE_PRINTF("a/%i.bmp");
  EXPECT_NAMES_LIKE_PRINTF("%08d_end");
  EXPECT_NAMES_LIKE_PRINTF("x%5d");
  EXPECT_NAMES_LIKE_PRINTF("100%%_%03d_%%d");
}

TEST(FilePattern, CountsBeyond32Bits) {
  EXPECT_EQ(FilePattern::parse("%u.gif")->name(UINT64_MAX), "18446744073709551615.gif");
}

TEST(FilePattern, NeedsOneNumber) {
  EXPECT_REFUSED(FilePattern::parse("picture.png"), OPTION_SYNTAX, "it has no number");
  EXPECT_REFUSED(FilePattern::parse(""), OPTION_SYNTAX, "it has no number");
  EXPECT_REFUSED(FilePattern::parse("%%d"), OPTION_SYNTAX, "it has no number");
  EXPECT_REFUSED(FilePattern::parse("%d_%d.png"), OPTION_SYNTAX, "it has a second number");
}

TEST(FilePattern, RejectsWhatWouldReadMemory) {
  for (const char* pattern : {"%s", "%n", "%p", "%", "%5", "%ld", "%*d", "%.3d", "%-3d", "%1$d",
                              "%x", "%c", "%f", "%d%n", "%d%"})
    EXPECT_FALSE(FilePattern::parse(pattern)) << pattern;
  EXPECT_REFUSED(FilePattern::parse("a%s"), OPTION_SYNTAX, "it has an unknown conversion");
  EXPECT_REFUSED(FilePattern::parse("a%s"), OPTION_SYNTAX, "first difference: at character 2:");
  EXPECT_REFUSED(FilePattern::parse("a%s"), OPTION_SYNTAX, "fix: location=sample_%04d.png");
}

TEST(FilePattern, RejectsWideNumbers) {
  EXPECT_EQ(FilePattern::parse("%032d")->name(1), "00000000000000000000000000000001");
  EXPECT_REFUSED(FilePattern::parse("%33d"), OPTION_SYNTAX, "its number is too wide");
  EXPECT_REFUSED(FilePattern::parse("%99999999999999999999999d"), OPTION_SYNTAX, "too wide");
}

}  // namespace file_pattern_test
}  // namespace weir::dataset
