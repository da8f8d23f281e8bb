// Checks that a model file exists.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "weir/result.hpp"

namespace weir::infer {

// MODEL_NOT_FOUND if the path is not a regular file; the error suggests another file.
Status check_model_file(const std::string& path);

// Returns the file that was probably meant: the same one below the prefix of the installation, or
// one of the folder with a similar name; "" if there is none.
std::string similar_model_file(const std::string& path);

}  // namespace weir::infer
