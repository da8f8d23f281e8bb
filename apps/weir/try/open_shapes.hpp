// The outputs of models whose input has an open size.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "core/infer/model/model.hpp"

namespace weir::app {

// The side of a picture where a model leaves it open, as published models have it.
inline constexpr int64_t kOpenSide = 640;

// The model's inputs with `shape` for the first one, else with the usual sizes for open extents.
std::vector<weir_tensor_info> sized_inputs(const infer::Model& model,
                                           const std::vector<int64_t>& shape);

// The outputs of the model for these inputs. Runs the model once on zeros if its outputs have open
// extents; where that fails, they stay open.
std::vector<weir_tensor_info> sized_outputs(const infer::Model& model, const std::string& path,
                                            const std::vector<weir_tensor_info>& inputs);

}  // namespace weir::app
