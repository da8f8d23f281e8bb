// Inputs for a model that is run to be measured: sizes where it leaves them open, and data.
#pragma once
#include <random>
#include <string>
#include <vector>

#include "commands.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::app {

// One frame: what the model says, what the user says of the rest, what a line of launch_line.hpp
// would choose. DIMENSION_SYNTAX, TYPE_SYNTAX; SPEC_MISMATCH where nobody says how many tensors.
Result<std::vector<weir_tensor_info>> inputs_of_frame(std::vector<weir_tensor_info> model,
                                                      const TensorWords& words);
// As properties of tensor_filter in a line for a shell: "input=3:224:224:1 inputtype=uint8".
std::string property_text(const TensorWords& words);
uint64_t bytes_of(const weir_tensor_info& info);  // of a shape that is known
// Numbers between 0 and 1, any bytes, wider integers 0 and 1.
void fill_with_made_up_data(const weir_tensor_info& info, void* data, std::mt19937& random);

}  // namespace weir::app
