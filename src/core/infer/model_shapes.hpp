// The ABI's tensor descriptions as ModelShape, and what two models differ in.
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

// The first difference in number, type or shape of tensors, in words; "" when there is none. Names
// may differ. `role`: "input" or "output".
std::string first_difference(const std::vector<ModelShape>& offered,
                             const std::vector<ModelShape>& needed, const std::string& role);
// "2 tensors: uint8 3:224:224:1, float32 4".
std::string list_shapes(const std::vector<ModelShape>& shapes);

}  // namespace weir
