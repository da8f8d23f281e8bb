// Derives output shapes from input shapes by the names that an ONNX model gives open dimensions.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string>
#include <vector>

#include "weir/abi.h"

namespace weir::engine {

using DimensionNames =
    std::vector<std::vector<std::string>>;  // per tensor and dimension, "" = none

// Sets the open dimensions of `outputs` whose name has exactly one size among `inputs`.
// `input_names` are the model's names for the dimensions of `inputs`.
void substitute_symbols(std::span<const weir_tensor_info> inputs, const DimensionNames& input_names,
                        std::span<weir_tensor_info> outputs, const DimensionNames& output_names);

}  // namespace weir::engine
