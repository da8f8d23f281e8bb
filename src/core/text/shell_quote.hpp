// Quotes text: for a shell, for a pipeline description, and as a part of an error.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>

namespace weir {

// The first two take any bytes; an argument and a value end at their first NUL.

// Quotes a word of a POSIX shell command line, if needed. The result contains no control characters
// but line feeds and tabs.
std::string shell_word(std::string_view text);
// Quotes the value of a property of type string in a pipeline description on a shell command line,
// for both. GStreamer refuses a value that is not UTF-8.
std::string launch_value(std::string_view text);

// The text in quotes: at most 64 characters of printable ASCII, other bytes as \xNN.
std::string quoted_text(std::string_view text);

}  // namespace weir
