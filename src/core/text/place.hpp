// place_in: where in a text something is wrong, as the "first difference" of an Error.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace weir {

// "at character 3:", below it the text in a line, below that a caret; "at the end:" behind the last
// character, "it is empty" of an empty text. Of a long text only what stands around the place.
// `position` is in bytes; characters are UTF-8's.
std::string place_in(std::string_view text, size_t position);

}  // namespace weir
