// mode=transpose: D0:D1:D2:3, or a permutation of five and more indices.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/transform/kernel.hpp"

namespace weir::transform {

Result<Operation> parse_transpose(std::string_view option);
TemplateSpec output_of(const Transpose& transpose, const TemplateSpec& in);
std::optional<TemplateSpec> input_of(const Transpose& transpose, const TemplateSpec& out);
std::shared_ptr<const Kernel> make_kernel(const Transpose& transpose, const TensorSpec& in,
                                          bool accelerate);

}  // namespace weir::transform
