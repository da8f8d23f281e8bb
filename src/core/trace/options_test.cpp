// Parses the parameters of GST_TRACERS="weir(...)".
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/options.hpp"

#include <gtest/gtest.h>

#include "says.hpp"

namespace weir::trace {
namespace options_test {

TEST(TraceOptions, HaveDefaults) {
  for (const char* text : {"", " "}) {
    const auto options = read_options(text);
    ASSERT_TRUE(options) << text;
    EXPECT_EQ(options->file, "weir-trace.json");
    EXPECT_EQ(options->limit, 4194304u);
  }
}

TEST(TraceOptions, AreReadInAnyOrder) {
  const auto options = read_options("limit = 12, file=a=b.json ");
  ASSERT_TRUE(options);
  EXPECT_EQ(options->file, "a=b.json");
  EXPECT_EQ(options->limit, 12u);
  EXPECT_EQ(read_options("file=")->file, "");
}

TEST(TraceOptions, UnknownNamesAreRejectedWithASuggestion) {
  const auto options = read_options("fle=x.json");
  ASSERT_FALSE(options);
  EXPECT_EQ(options.error().code, Code::OPTION_SYNTAX);
  EXPECT_EQ(options.error().offered, "fle=x.json");
  EXPECT_EQ(options.error().fix, "GST_TRACERS=\"weir(file=x.json)\"");
  for (const char* text : {"file", "file=x,", "nothing like it=3"})
    EXPECT_FALSE(read_options(text)) << text;
}

TEST(TraceOptions, InvalidNumbersOfRecordsAreRejected) {
  for (const char* text :
       {"limit", "limit=", "limit=0", "limit=-1", "limit=1e6", "limit=99999999999999"}) {
    const auto options = read_options(text);
    ASSERT_FALSE(options) << text;
    EXPECT_SAYS(options.error().message(), "limit= with a number of records");
  }
}

}  // namespace options_test
}  // namespace weir::trace
