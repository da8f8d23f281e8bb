// mode=typecast: TYPE.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/transform/kernel.hpp"

namespace weir::transform {

Result<Operation> parse_typecast(std::string_view option);
TemplateSpec output_of(const Typecast& typecast, const TemplateSpec& in);
std::optional<TemplateSpec> input_of(const Typecast& typecast, const TemplateSpec& out);
std::shared_ptr<const Kernel> make_kernel(const Typecast& typecast, const TensorSpec& in,
                                          bool accelerate);

}  // namespace weir::transform
