// Text of unknown origin as a part of an error.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>

namespace weir {

// The text in quotes: at most 64 characters of printable ASCII, other bytes as \xNN.
std::string quoted_text(std::string_view text);

}  // namespace weir
