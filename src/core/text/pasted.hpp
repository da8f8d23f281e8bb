// Quotes text for command lines that users paste into a shell.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>

namespace weir {

// One word of a POSIX shell command line, quoted only if needed.
std::string shell_word(std::string_view text);
// A property value in a pipeline description on a shell command line: quoted for both.
std::string launch_value(std::string_view text);

}  // namespace weir
