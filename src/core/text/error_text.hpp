// Parts of errors: the position of a mistake, and the values that are allowed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "weir/result.hpp"

namespace weir {

// "at character 3:", then the text on its own line, then a caret below the character. "at the end:"
// after the last character, "it is empty" for an empty text. Long texts are cut around the
// position. `position` counts bytes; the message counts UTF-8 characters.
std::string place_in(std::string_view text, size_t position);

// "one of: a, b, c"
std::string one_of(std::span<const std::string> words);
// OPTION_VALUE with the offered value, the allowed ones and, if one is similar, the nearest.
Error not_one_of(std::string what, const std::string& offered, std::span<const std::string> words);

}  // namespace weir
