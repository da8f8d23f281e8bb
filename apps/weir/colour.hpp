// Colours of text on a terminal.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdio>
#include <string>
#include <string_view>

namespace weir::app {

enum class Colour { Red, Yellow, Green };

// Whether `stream` is a terminal that shows colours: never when the variable NO_COLOR is set to
// anything but "", or TERM is "dumb".
bool shows_colours(std::FILE* stream);
// `text` in a colour, as it is where the stream shows none.
std::string coloured(std::FILE* stream, Colour colour, std::string_view text);
// The lines of an error with the first in red and the fix in green.
std::string coloured_error(std::FILE* stream, std::string_view message);

}  // namespace weir::app
