// Words of command lines that users paste into a shell.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>

namespace weir {

// One word of a POSIX shell's command line, quoted only where needed.
std::string shell_word(std::string_view text);
// A property's value inside a pipeline description that a shell passes on: quoted for both.
std::string launch_value(std::string_view text);

}  // namespace weir
