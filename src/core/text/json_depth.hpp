// How deeply a JSON text is nested, found before it is parsed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string_view>

namespace weir {

// The number of lists and objects that enclose each other, 0 for a number. The functions of
// nlohmann's library that copy, compare and print a value call themselves for each of them, so that
// a hostile file could exhaust the stack. (A callback of its parser takes quadratic time.)
int json_depth(std::string_view text) noexcept;

}  // namespace weir
