// The words of a pipeline's text, as gst-launch-1.0 cuts them.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "weir/result.hpp"

namespace weir::app {

struct LaunchWord {
  std::string text;      // without quotes and backslashes
  size_t at = 0;         // where it begins
  bool assigns = false;  // a = outside quotes: key=value
};

// OPTION_SYNTAX: a quote without its end.
Result<std::vector<LaunchWord>> launch_words(std::string_view text);
// OPTION_SYNTAX with the text and a caret.
Error launch_error(std::string_view text, size_t at, std::string what, std::string needed);

}  // namespace weir::app
