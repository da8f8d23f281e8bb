// Parses property files (the property config-file): lines of key=value.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string_view>
#include <utility>
#include <vector>

namespace weir {

// Keys and values in the order of the lines, without surrounding blanks; views into `text`. Skips
// lines without `=` and lines without a key.
std::vector<std::pair<std::string_view, std::string_view>> parse_property_file(
    std::string_view text);

}  // namespace weir
