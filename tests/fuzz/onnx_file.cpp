// Fuzz target: what the ONNX Runtime module reads of a model file before the engine sees it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdint>
#include <span>

#include "onnxruntime/onnx_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  (void)weir::engine::onnx_score({data, size});
  (void)weir::engine::read_onnx(std::as_bytes(std::span(data, size)));
  return 0;
}
