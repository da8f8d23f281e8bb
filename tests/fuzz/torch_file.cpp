// Fuzz target: checks a zip archive as the libtorch module does before libtorch reads it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdint>
#include <span>

#include "pytorch/torch_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  (void)weir::engine::check_torch_file(
      weir::engine::ModelSource(std::as_bytes(std::span(data, size))));
  return 0;
}
