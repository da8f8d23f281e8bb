// mode=stand: (default|dc-average)[:TYPE][,per-channel:(true|false)] standardises a tensor by its
// own mean and deviation.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/transform/kernel.hpp"

namespace weir::transform {

Result<Operation> parse_stand(std::string_view option);
TemplateSpec get_output(const Stand& stand, const TemplateSpec& in);
std::optional<TemplateSpec> find_input(const Stand& stand, const TemplateSpec& out);
std::shared_ptr<const Kernel> make_kernel(const Stand& stand, const TensorSpec& in,
                                          bool accelerate);

// Elements whose channels repeat in every row: `rows` of `width` elements, `stride` elements apart,
// starting at `begin`, plus `tail` elements. Position j of a row belongs to channel j % channels;
// channels <= width <= kChainBlock.
struct StandStrip {
  size_t begin = 0, width = 0, stride = 0, rows = 0, tail = 0, channels = 1;
};

struct StandTypes {
  ElementType from, to;
  bool divides;  // true: |x - mean| / deviation; false: x - mean
};

struct StandScale;  // stand_scale.hpp

// Computes in double, with the same result on every CPU. `in` and `out` are the start of the
// tensor. `scale` holds mean and deviation of at most kFewChannels if they are known, else null.
// (stand_strip.cpp)
void run_stand_strip(const StandStrip& strip, const StandTypes& types, const StandScale* scale,
                     bool accelerate, const std::byte* in, std::byte* out) noexcept;

// Whether results of this type are products with 1 / deviation. The relative error is 2^-52: at
// most the last bit of a float32, but enough to move an integer result below the integer.
constexpr bool divides_by_product(ElementType to) noexcept {
  return to == ElementType::Float32 || to == ElementType::Float16;
}

}  // namespace weir::transform
