// The description of a lowered model, for whichever engine opened it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string>

#include "lowering/lowering.hpp"
#include "weir/abi.h"

namespace weir::engine {

// Makes weir_model_info::metadata_json: the .tflite file's metadata and "lowering": "onnxruntime".
std::string lowered_metadata(std::span<const std::byte> tflite);

// Sets the source's quantisation and layout, which the lowered graph cannot express.
void lay_over(std::span<const PortQuantization> source, std::span<weir_tensor_info> ports);

}  // namespace weir::engine
