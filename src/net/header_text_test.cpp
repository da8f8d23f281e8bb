// What the headers of calls can carry.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <string>

#include "net/header_text.hpp"

namespace weir::net {
namespace header_text_test {

TEST(HeaderTexts, ArePrintableAscii) {
  for (int byte = 0; byte < 256; ++byte)
    EXPECT_EQ(is_header_value(std::string(1, static_cast<char>(byte))), byte >= 32 && byte < 127)
        << byte;
  EXPECT_TRUE(is_header_value(""));
  EXPECT_FALSE(is_header_value("\xEF\xBB\xBFtoken"));
}

TEST(HeaderTexts, HaveATraceOnlyInTheFormOfTraceContext) {
  const std::string trace = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01";
  EXPECT_TRUE(is_trace_parent(trace));
  for (size_t i = 0; i < trace.size(); ++i)
    for (const char wrong : {'g', 'A', ' ', '\0', '\x7f', '\x80'}) {
      std::string other = trace;
      other[i] = wrong;
      EXPECT_FALSE(is_trace_parent(other)) << other;
    }
  EXPECT_FALSE(is_trace_parent(""));
  EXPECT_FALSE(is_trace_parent(trace + "-00"));
  EXPECT_FALSE(is_trace_parent(trace.substr(1)));
}

}  // namespace header_text_test
}  // namespace weir::net
