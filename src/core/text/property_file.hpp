// Property files: lines of key=value, as the property config-file names one.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string_view>
#include <utility>
#include <vector>

namespace weir {

// Keys and values in the order of the lines, without blanks around them; views into `text`. Lines
// without `=` are passed over, and so is a line without a key.
std::vector<std::pair<std::string_view, std::string_view>> parse_property_file(
    std::string_view text);

}  // namespace weir
