// Converts the ABI's tensor descriptions to ModelShape and compares those of two models.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "core/filter/model_shape.hpp"
#include "weir/abi.h"

namespace weir {

ModelShape model_shape(const weir_tensor_info& info);
std::vector<ModelShape> model_shapes(const std::vector<weir_tensor_info>& infos);
weir_tensor_info tensor_info(const ModelShape& shape);  // its name points into `shape`
std::vector<weir_tensor_info> tensor_infos(const std::vector<ModelShape>& shapes);

// Describes the first difference in number, type or shape of tensors; "" without one. Names may
// differ. `role`: "input" or "output".
std::string first_difference(const std::vector<ModelShape>& offered,
                             const std::vector<ModelShape>& needed, const std::string& role);
// Tensors of a frame with types, shapes and sizes (0 where open); data stay null. Their names point
// into `shapes`.
std::vector<weir_tensor> frame_tensors(const std::vector<ModelShape>& shapes);

}  // namespace weir
