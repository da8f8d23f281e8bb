// OutputValues: the outputs of a frame as real numbers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <deque>
#include <span>
#include <vector>

#include "weir/module.hpp"

namespace weir::heads {

// Number of elements by the shape; throws Failure (SPEC_MISMATCH) for a shape with open extents or
// more than 2^31 elements.
size_t element_count(const weir_tensor_info& info);
// The elements of `tensor` as float32 in memory order: scale * (value - zero_point) if `dequantise`
// and the tensor is quantised. Those of aligned float32 are not copied, others are in `converted`.
// Throws as element_count(), and Failure (FRAME_SIZE) if the memory does not fit the shape.
std::span<const float> read_values(const weir_tensor& tensor, bool dequantise,
                                   std::vector<float>* converted);

// Each tensor is converted at most once a frame, and memory is kept from frame to frame. Used by
// one thread at a time.
class OutputValues {
 public:
  // Borrows the tensors of the next frame. Their info has the quantisation, if any.
  void begin(std::span<const weir_tensor> tensors);
  size_t size() const noexcept { return tensors_.size(); }
  const weir_tensor_info& info(size_t index) const noexcept { return tensors_[index].info; }
  // All elements of tensor `index` in memory order: scale * (value - zero_point) of quantised
  // tensors. Aligned float32 is not copied. Throws Failure: SPEC_MISMATCH if there is no such
  // tensor, FRAME_SIZE when the memory does not fit the shape.
  std::span<const float> read(size_t index);
  // Without the quantisation: indices of classes, for example.
  std::span<const float> read_raw(size_t index);

 private:
  std::span<const float> read(size_t index, bool dequantise);

  std::span<const weir_tensor> tensors_;
  std::vector<std::vector<float>> converted_;  // by tensor
  std::vector<std::span<const float>> known_;  // of this frame
};

}  // namespace weir::heads
