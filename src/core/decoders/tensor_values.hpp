// Reads the tensors of a frame as float32, which is what the decoders of NNStreamer's modes compute
// with.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <vector>

#include "core/heads/output_values.hpp"

namespace weir::decoders {

using heads::element_count;

// Keeps one buffer for conversions, so that a stream allocates once.
class TensorValues {
 public:
  // heads::read_values() with quantisation. Valid until the next call and while the tensor is.
  std::span<const float> read(const weir_tensor& tensor) {
    return heads::read_values(tensor, true, &converted_);
  }

 private:
  std::vector<float> converted_;
};

}  // namespace weir::decoders
