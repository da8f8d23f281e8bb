// Comparison: a condition for the tensors of one stream, and its answer for a frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <vector>

#include "core/condition/condition.hpp"
#include "core/tensor/frame_spec.hpp"

namespace weir::condition {

// Not for Custom. Immutable.
class Comparison {
 public:
  // Precondition: nothing is missing(). A tensor or coordinate that the stream has not is an error
  // that names both.
  static Result<Comparison> make(const Condition& condition,
                                 const std::vector<TensorSpec>& tensors);

  // What of the frame is looked at.
  size_t tensor() const noexcept { return tensor_; }
  size_t offset() const noexcept { return offset_; }  // bytes, in the tensor
  size_t bytes() const noexcept { return bytes_; }

  // `bytes` are those. The supplied values become numbers of the tensor's type first, as C casts
  // them; an average is computed in float64 and becomes one, too.
  bool holds(std::span<const std::byte> bytes) const noexcept;

 private:
  Condition condition_;
  ElementType type_ = ElementType::End;
  size_t tensor_ = 0, offset_ = 0, bytes_ = 0;
};

// Of `bytes` that are dense elements of `type`.
double average(ElementType type, std::span<const std::byte> bytes) noexcept;

}  // namespace weir::condition
