// The names that engines and accelerators have in Weir for the numbers of the C face.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>

#include "capi-nnstreamer/nnstreamer-single.h"

namespace weir::application {

// nullopt: no such number. "": by the model's file. `model` decides between the custom engines.
std::optional<std::string> framework_name(ml_nnfw_type_e type, const std::string& model);
// "cpu", "npu.edgetpu"; "": the engine's choice.
std::optional<std::string> accelerator_name(ml_nnfw_hw_e hardware);

}  // namespace weir::application
