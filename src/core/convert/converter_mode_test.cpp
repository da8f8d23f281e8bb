// The property mode of tensor_converter.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/convert/converter_mode.hpp"

#include <gtest/gtest.h>

namespace weir {
namespace converter_mode_test {

using Kind = ConverterMode::Kind;

TEST(ConverterMode, ParsesKindAndName) {
  EXPECT_EQ(parse_converter_mode("")->kind, Kind::ByCaps);
  EXPECT_EQ(parse_converter_mode("  ")->kind, Kind::ByCaps);
  for (const char* text : {"custom-code:add", "CUSTOM-Code: add ", "custom-code:add:rest"}) {
    const auto mode = parse_converter_mode(text);
    ASSERT_TRUE(mode) << text;
    EXPECT_EQ(mode->kind, Kind::CustomCode);
    EXPECT_EQ(mode->name, "add");
  }
  const auto script = parse_converter_mode("custom-script:/a/b.py");
  EXPECT_EQ(script->kind, Kind::CustomScript);
  EXPECT_EQ(script->name, "/a/b.py");
}

TEST(ConverterMode, RequiresKindAndName) {
  for (const char* text : {"custom-code", "custom-code:", "custom-code: ", "add", ":"})
    EXPECT_EQ(parse_converter_mode(text).error().code, Code::OPTION_SYNTAX) << text;
  for (const char* text : {"code:add", ":add", "custom:add"}) {
    const auto mode = parse_converter_mode(text);
    EXPECT_EQ(mode.error().code, Code::MODE_UNKNOWN) << text;
    EXPECT_EQ(mode.error().fix, "tensor_converter mode=custom-code:NAME");
  }
}

}  // namespace converter_mode_test
}  // namespace weir
