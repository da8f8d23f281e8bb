// The engine custom-easy: filters of the application (docs/compatibility/filter.md 4.11).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::custom {

const weir_engine& custom_easy_engine();

// Filters of the application declare whether they need invoke-dynamic; OPTION_VALUE if the user's
// setting differs. Models of other engines work with both.
Status check_invocation(const weir_engine& engine, const weir_model_info& info,
                        const std::string& model, bool invoke_dynamic);

}  // namespace weir::custom
