// Reads the tensors of a frame as float32, which is what the built-in decoders compute with.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <vector>

#include "weir/module.hpp"

namespace weir::decoders {

// Number of elements by the shape; throws Failure (SPEC_MISMATCH) for a shape with open extents or
// more than 2^31 elements.
size_t element_count(const weir_tensor_info& info);

// Keeps one buffer for conversions, so that a stream allocates once.
class TensorValues {
 public:
  // The elements of `tensor`, without a copy for aligned float32. Valid until the next call and
  // while the tensor is. Throws Failure (FRAME_SIZE) when the memory does not fit the shape.
  std::span<const float> read(const weir_tensor& tensor);

 private:
  std::vector<float> converted_;
};

}  // namespace weir::decoders
