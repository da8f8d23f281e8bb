// The shapes of models that leave them open.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "core/infer/model/model.hpp"
#include "weir/abi.h"

namespace weir::app {

// The model's inputs with `shape` for the first one, else with the sizes of its metadata for open
// extents, or those of published models (640).
std::vector<weir_tensor_info> sized_inputs(const infer::Model& model,
                                           const std::vector<int64_t>& shape);

// The outputs of the model for these inputs. Runs the model once on zeros if its outputs have open
// extents; where that fails, they stay open.
std::vector<weir_tensor_info> sized_outputs(const infer::Model& model, const std::string& path,
                                            const std::vector<weir_tensor_info>& inputs);

}  // namespace weir::app
