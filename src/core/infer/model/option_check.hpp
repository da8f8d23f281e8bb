// Compares the options of custom= with those that an engine of the user declares.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string>
#include <utility>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::infer {

// OPTION_VALUE for a key that options_json does not list, and for a value that is not of its type.
// Accepts everything for engines that declare no options or take the whole text of custom=, and
// for Weir's own, which look at their options themselves.
Status check_options(const weir_engine& engine,
                     std::span<const std::pair<std::string, std::string>> options);

}  // namespace weir::infer
