// Fuzz target: parses a model file as the ONNX Runtime module does before the engine reads it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdint>
#include <span>

#include "onnxruntime/onnx_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  (void)weir::engine::onnx_score({data, size});
  (void)weir::engine::read_onnx(std::as_bytes(std::span(data, size)));
  return 0;
}
