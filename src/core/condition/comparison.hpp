// Comparison: a condition resolved for the tensors of one stream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <vector>

#include "core/condition/condition.hpp"
#include "core/tensor/frame_spec.hpp"

namespace weir::condition {

// For every kind but Custom. Immutable.
class Comparison {
 public:
  // Precondition: missing() returns nothing. If the stream lacks the tensor or coordinate, the
  // error names both.
  static Result<Comparison> make(const Condition& condition,
                                 const std::vector<TensorSpec>& tensors);

  // The part of the frame that is compared.
  size_t tensor() const noexcept { return tensor_; }
  size_t offset() const noexcept { return offset_; }  // bytes, in the tensor
  size_t bytes() const noexcept { return bytes_; }

  // `bytes` is that part. Supplied values are first cast to the tensor's type as C does; an average
  // is computed in float64 and cast to it as well.
  bool holds(std::span<const std::byte> bytes) const noexcept;

 private:
  Condition condition_;
  ElementType type_ = ElementType::End;
  size_t tensor_ = 0, offset_ = 0, bytes_ = 0;
};

// The average of dense elements of `type`.
double average(ElementType type, std::span<const std::byte> bytes) noexcept;

}  // namespace weir::condition
