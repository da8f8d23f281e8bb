// Fuzz target: what the TensorFlow Lite module checks of a model file before the engine sees it.
#include <cstdint>
#include <span>

#include "tensorflow-lite/tflite_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  (void)weir::engine::read_tflite(std::as_bytes(std::span(data, size)));
  return 0;
}
