// Writes the escape sequences of ECMA-48.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "colour.hpp"

#include <unistd.h>

#include "machine/environment.hpp"

namespace weir::app {

bool shows_colours(std::FILE* stream) {
  const char* const no_colour = environment_variable("NO_COLOR");
  const char* const terminal = environment_variable("TERM");
  if ((no_colour && *no_colour) || !terminal || std::string_view(terminal) == "dumb") return false;
  return isatty(fileno(stream)) == 1;
}

std::string coloured(std::FILE* stream, Colour colour, std::string_view text) {
  if (text.empty() || !shows_colours(stream)) return std::string(text);
  const char* const code = colour == Colour::Red      ? "\033[1;31m"
                           : colour == Colour::Yellow ? "\033[1;33m"
                                                      : "\033[32m";
  return code + std::string(text) + "\033[0m";
}

std::string coloured_error(std::FILE* stream, std::string_view message) {
  constexpr std::string_view kFix = "\n  fix: ";
  const size_t line = message.find('\n'), fix = message.rfind(kFix);
  std::string out = coloured(stream, Colour::Red, message.substr(0, line));
  if (line == std::string_view::npos) return out;
  if (fix == std::string_view::npos) return out + std::string(message.substr(line));
  return out + std::string(message.substr(line, fix - line)) + "\n" +
         coloured(stream, Colour::Green, message.substr(fix + 1));
}

}  // namespace weir::app
