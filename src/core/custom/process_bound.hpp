// Identifies filters that only work in the process that registered them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <span>
#include <string>

#include "weir/result.hpp"

namespace weir::custom {

// OPTION_VALUE for filters and classes that exist in this process only; nullopt for engines and
// libraries, which a worker process can load.
std::optional<Error> bound_to_this_process(const std::string& engine,
                                           std::span<const std::string> paths);

}  // namespace weir::custom
