// The numbers of ml_nnfw_type_e and ml_nnfw_hw_e as words of tensor_filter
// (docs/compatibility/app-api.md 8.7).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <span>
#include <string>

#include "capi-nnstreamer/ml-api-common.h"
#include "weir/result.hpp"

namespace weir::application {

// "" for ML_NNFW_TYPE_ANY; OPTION_VALUE for a number that is none.
Result<std::string> framework_name(ml_nnfw_type_e type);
// ML_NNFW_TYPE_ANY for a name that has no number.
ml_nnfw_type_e framework_number(const std::string& name);
// "default", "auto", "cpu" and so on; "auto" for a number that is none.
std::string accelerator_name(ml_nnfw_hw_e hardware);

// Checks that a framework reads files of this name. OPTION_VALUE: it reads others.
Status check_model_name(ml_nnfw_type_e type, std::span<const std::string> paths);
// Whether NNStreamer's library has the framework in its list but no way to open it.
bool is_unsupported(ml_nnfw_type_e type);
// Whether a program must describe the tensors of the framework's models.
bool needs_infos(ml_nnfw_type_e type);

// Checks that an engine of this name is installed and runs on this hardware, a name of
// accelerator_name(). `custom` is passed to sub-plugins; null: none.
Status check_available(const std::string& framework, const std::string& accelerator,
                       const char* custom);

}  // namespace weir::application
