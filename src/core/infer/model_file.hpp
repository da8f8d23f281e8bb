// Is there a file where a model is said to be?
#pragma once
#include <string>

#include "weir/result.hpp"

namespace weir::infer {

// MODEL_NOT_FOUND when the path is no regular file, with a name nearby that is one.
Status check_model_file(const std::string& path);

}  // namespace weir::infer
