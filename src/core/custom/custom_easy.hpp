// The engine custom-easy: filters that a program registered (specification 4.11).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::custom {

const weir_engine& custom_easy_engine();

// Filters of a process say whether they are invoked with invoke-dynamic; OPTION_VALUE when the user
// says otherwise. Models of other engines may be used either way.
Status check_invocation(const weir_engine& engine, const weir_model_info& info,
                        const std::string& model, bool invoke_dynamic);

}  // namespace weir::custom
