// Concatenation: joins several tensors to one along a dimension.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "core/tensor/frame_spec.hpp"

namespace weir {

class Concatenation {
 public:
  // All inputs need the same type and the same size in every other dimension; missing dimensions
  // are 1. SPEC_MISMATCH shows both sides; LIMIT_EXCEEDED if the sum does not fit.
  static Result<Concatenation> plan(std::span<const TensorSpec> inputs, size_t dimension);

  const TensorSpec& output() const noexcept { return output_; }
  // Each input and `out` have the sizes of the plan. Writes each byte of `out` once.
  void run(std::span<const std::span<const std::byte>> inputs, std::span<std::byte> out) const;

 private:
  void run_streamed(std::span<const std::span<const std::byte>> inputs, std::byte* out) const;

  TensorSpec output_;
  std::vector<size_t> blocks_;  // bytes of each input in a row
  size_t row_ = 0;              // their sum
  size_t rows_ = 0;
};

}  // namespace weir
