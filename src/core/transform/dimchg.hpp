// mode=dimchg: FROM:TO moves one dimension to another place; a special case of transposition.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/transform/kernel.hpp"

namespace weir::transform {

Result<Operation> parse_dimchg(std::string_view option);
TemplateSpec output_of(const Dimchg& dimchg, const TemplateSpec& in);
std::optional<TemplateSpec> input_of(const Dimchg& dimchg, const TemplateSpec& out);
std::shared_ptr<const Kernel> make_kernel(const Dimchg& dimchg, const TensorSpec& in,
                                          bool accelerate);

}  // namespace weir::transform
