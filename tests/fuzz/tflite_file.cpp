// Fuzz target: checks a model file as the TensorFlow Lite module does before the engine reads it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdint>
#include <span>

#include "tflite-file/tflite_file.hpp"
#include "tflite-file/tflite_metadata.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const auto file = std::as_bytes(std::span(data, size));
  const auto summary = weir::engine::read_tflite(file);
  (void)weir::engine::tflite_properties(file, summary ? summary->metadata : file);
  return 0;
}
