// Checks that a model file exists.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "weir/result.hpp"

namespace weir::infer {

// MODEL_NOT_FOUND if the path is not a regular file; the error suggests another file.
Status check_model_file(const std::string& path);

}  // namespace weir::infer
