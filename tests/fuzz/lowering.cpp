// Fuzz target: lowers .tflite files for ONNX Runtime. The result is a complete ONNX file.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lowering/lowering.hpp"

#include "fuzz_input.hpp"
#include "onnxruntime/onnx_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const auto file = std::as_bytes(std::span(data, size));
  const auto lowered = weir::engine::lower_tflite(file);
  if (!lowered) {
    weir::fuzz::require(!lowered.error().what.empty(), "an error has a text");
    return 0;
  }
  const auto onnx = weir::engine::read_onnx(std::as_bytes(std::span(lowered->onnx)));
  weir::fuzz::require(static_cast<bool>(onnx), "a translated model is an ONNX file");
  return 0;
}
