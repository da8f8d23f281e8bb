// mode=clamp: MIN:MAX limits every element to a range.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/transform/kernel.hpp"

namespace weir::transform {

Result<Operation> parse_clamp(std::string_view option);
TemplateSpec get_output(const Clamp& clamp, const TemplateSpec& in);
std::optional<TemplateSpec> find_input(const Clamp& clamp, const TemplateSpec& out);
std::shared_ptr<const Kernel> make_kernel(const Clamp& clamp, const TensorSpec& in,
                                          bool accelerate);

// The limits in the tensor's own type T: x < first becomes low, x > last becomes high. If no value
// of T is in the range, `fill` is true and every element becomes low.
template <class T>
struct Limits {
  T first{}, low{}, last{}, high{};
  bool fill = false;
};

// Leaves NaN unchanged. (clamp_blocks.cpp)
void run_clamp(const std::byte* in, std::byte* out, size_t count, ElementType type,
               const std::byte* limits) noexcept;

}  // namespace weir::transform
