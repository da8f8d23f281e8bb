// mode=padding: adds zeros around the three innermost dimensions.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/transform/kernel.hpp"

namespace weir::transform {

Result<Operation> parse_padding(std::string_view option);
TemplateSpec output_of(const Padding& padding, const TemplateSpec& in);
// The shape stays open, because padding cannot be inverted.
std::optional<TemplateSpec> input_of(const Padding& padding, const TemplateSpec& out);
std::shared_ptr<const Kernel> make_kernel(const Padding& padding, const TensorSpec& in,
                                          bool accelerate);

}  // namespace weir::transform
