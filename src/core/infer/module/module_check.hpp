// Validates the tables of a module before any of their functions is called.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::infer {

// MODULE_REFUSED with `path`, the actual and the required property.
Error module_refused(const std::string& path, std::string offered, std::string needed);
// The error of dlopen() for this file; `reason`: what dlerror() returned, may be null.
Error module_not_loaded(const std::string& path, const char* reason);

// Checks the tables of a module: versions, sizes, names and required functions.
Status check_module(const weir_module* module, const std::string& path);

}  // namespace weir::infer
