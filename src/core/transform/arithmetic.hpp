// mode=arithmetic: [typecast:TYPE,][per-channel:(false|true@DIM),]OP:NUMBER[@CH],...
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/transform/kernel.hpp"

namespace weir::transform {

Result<Operation> parse_arithmetic(std::string_view option);
TemplateSpec output_of(const Arithmetic& arithmetic, const TemplateSpec& in);
std::optional<TemplateSpec> input_of(const Arithmetic& arithmetic, const TemplateSpec& out);
std::shared_ptr<const Kernel> make_kernel(const Arithmetic& arithmetic, const TensorSpec& in,
                                          bool accelerate);

}  // namespace weir::transform
