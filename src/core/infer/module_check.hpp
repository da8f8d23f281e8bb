// Is what a module hands over usable? Nothing of it is called before.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::infer {

// MODULE_REFUSED naming `path`, what was found and what was needed.
Error module_refused(const std::string& path, std::string offered, std::string needed);

// The tables of a module: versions, sizes, names, and the functions without which none can work.
Status check_module(const weir_module* module, const std::string& path);

}  // namespace weir::infer
