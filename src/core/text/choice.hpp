// A word that is none of those there are, as an error.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string>

#include "weir/result.hpp"

namespace weir {

// "one of: a, b, c"
std::string one_of(std::span<const std::string> words);
// OPTION_VALUE: what was offered, the words there are, the nearest one where one is near.
Error not_one_of(std::string what, const std::string& offered, std::span<const std::string> words);

}  // namespace weir
