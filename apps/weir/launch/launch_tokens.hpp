// Splits a pipeline's text into words as gst-launch-1.0 does.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "weir/result.hpp"

namespace weir::app {

struct LaunchToken {
  std::string text;      // without quotes and backslashes
  size_t at = 0;         // offset of its first character
  bool assigns = false;  // contains a = outside quotes: key=value
};

// OPTION_SYNTAX for an unterminated quote.
Result<std::vector<LaunchToken>> launch_tokens(std::string_view text);
// OPTION_SYNTAX with the text and a caret below position `at`.
Error launch_error(std::string_view text, size_t at, const std::string& what, std::string needed);

}  // namespace weir::app
