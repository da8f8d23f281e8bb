// Errors for a value that is not one of the allowed values.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string>

#include "weir/result.hpp"

namespace weir {

// "one of: a, b, c"
std::string one_of(std::span<const std::string> words);
// OPTION_VALUE with the offered value, the allowed ones and, if one is similar, the nearest.
Error not_one_of(std::string what, const std::string& offered, std::span<const std::string> words);

}  // namespace weir
