// The element-wise chain: a conversion and any sequence of add, mul and div in one pass.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/transform/kernel.hpp"

namespace weir::transform {

// Converts in.type to `to` and then applies the steps in order. With `channel_dimension`, a step
// with a channel applies only to elements with that index in the dimension; otherwise the channels
// of steps are ignored.
std::shared_ptr<const Kernel> make_chain_kernel(const TensorSpec& in, ElementType to,
                                                std::span<const ArithmeticStep> steps,
                                                std::optional<size_t> channel_dimension,
                                                bool accelerate);

// The channel of an element is (index / inner) % count.
struct Channels {
  size_t inner = 1;
  size_t count = 1;
};

// A step with its operand in the tensor's type.
struct TypedStep {
  Operator op = Operator::Add;
  std::optional<uint32_t> channel;
  alignas(8) std::byte operand[8] = {};

  template <class T>
  T operand_as() const noexcept {
    T value;
    __builtin_memcpy(&value, operand, sizeof(T));
    return value;
  }
  bool touches(size_t index) const noexcept { return !channel || *channel == index; }
};

}  // namespace weir::transform
