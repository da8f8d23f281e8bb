// Weir's names of engines and accelerators for the numbers of the C API.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>

#include "capi-nnstreamer/nnstreamer-single.h"

namespace weir::application {

// nullopt: invalid number. "": chosen by the model file. `model` selects among the custom engines.
std::optional<std::string> framework_name(ml_nnfw_type_e type, const std::string& model);
// For example "cpu" or "npu.edgetpu"; "": the engine's choice.
std::optional<std::string> accelerator_name(ml_nnfw_hw_e hardware);

}  // namespace weir::application
