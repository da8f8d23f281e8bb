// Outputs of another size than was told before the first frame.
#pragma once
#include "core/filter/model_shape.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir {

// Type, rank and every dimension.
bool same_shape(const weir_tensor_info& a, const weir_tensor_info& b) noexcept;
Error changed_size(size_t index, const weir_tensor_info& given, const ModelShape& told);

}  // namespace weir
