// place_in: the position of a mistake in a text, as the `difference` of an Error.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace weir {

// "at character 3:", then the text on its own line, then a caret below the character. "at the end:"
// after the last character, "it is empty" for an empty text. Long texts are cut around the
// position. `position` counts bytes; the message counts UTF-8 characters.
std::string place_in(std::string_view text, size_t position);

}  // namespace weir
