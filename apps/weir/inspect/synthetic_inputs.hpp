// Makes inputs for measuring a model: sizes for open dimensions, and data.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <random>
#include <string>
#include <vector>

#include "commands.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::app {

// Inputs of one frame, from the model, then the user's values, then the defaults of
// launch_line.hpp. DIMENSION_SYNTAX, TYPE_SYNTAX; SPEC_MISMATCH if the number of tensors is
// unknown.
Result<std::vector<weir_tensor_info>> inputs_of_frame(std::vector<weir_tensor_info> model,
                                                      const TensorOptions& tensors);
// Formats as tensor_filter properties for a shell: "input=3:224:224:1 inputtype=uint8".
std::string property_text(const TensorOptions& tensors);
uint64_t count_bytes(const weir_tensor_info& info);  // precondition: the shape is fixed
// Floats between 0 and 1, any bytes, and 0 or 1 for wider integers.
void fill_with_random_data(const weir_tensor_info& info, void* data, std::mt19937& random);

}  // namespace weir::app
