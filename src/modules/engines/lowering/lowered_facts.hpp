// What a lowered model says of itself, whichever engine opened it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string>

#include "lowering/lowering.hpp"
#include "weir/abi.h"

namespace weir::engine {

// weir_model_info::metadata_json: what the .tflite file says, and "lowering": "onnxruntime".
std::string lowered_metadata(std::span<const std::byte> tflite);

// The source's quantisation and layout, which the lowered graph has no place for.
void lay_over(std::span<const PortQuantization> source, std::span<weir_tensor_info> ports);

}  // namespace weir::engine
