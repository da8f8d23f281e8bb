// The modes arithmetic, dimchg, padding, transpose and typecast: how each reads its option, what it
// makes of a type and shape, and its kernel.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/transform/kernel.hpp"

namespace weir::transform {

// mode=arithmetic: [typecast:TYPE,][per-channel:(false|true@DIM),]OP:NUMBER[@CH],...

Result<Operation> parse_arithmetic(std::string_view option);
TemplateSpec get_output(const Arithmetic& arithmetic, const TemplateSpec& in);
std::optional<TemplateSpec> find_input(const Arithmetic& arithmetic, const TemplateSpec& out);
std::shared_ptr<const Kernel> make_kernel(const Arithmetic& arithmetic, const TensorSpec& in,
                                          bool accelerate);

// mode=dimchg: FROM:TO moves one dimension to another place; a special case of transposition.

Result<Operation> parse_dimchg(std::string_view option);
TemplateSpec get_output(const Dimchg& dimchg, const TemplateSpec& in);
std::optional<TemplateSpec> find_input(const Dimchg& dimchg, const TemplateSpec& out);
std::shared_ptr<const Kernel> make_kernel(const Dimchg& dimchg, const TensorSpec& in,
                                          bool accelerate);

// mode=padding: adds zeros around the three innermost dimensions.

Result<Operation> parse_padding(std::string_view option);
TemplateSpec get_output(const Padding& padding, const TemplateSpec& in);
// The shape stays open, because padding cannot be inverted.
std::optional<TemplateSpec> find_input(const Padding& padding, const TemplateSpec& out);
std::shared_ptr<const Kernel> make_kernel(const Padding& padding, const TensorSpec& in,
                                          bool accelerate);

// mode=transpose: D0:D1:D2:3, or a permutation of five and more indices.

Result<Operation> parse_transpose(std::string_view option);
TemplateSpec get_output(const Transpose& transpose, const TemplateSpec& in);
std::optional<TemplateSpec> find_input(const Transpose& transpose, const TemplateSpec& out);
std::shared_ptr<const Kernel> make_kernel(const Transpose& transpose, const TensorSpec& in,
                                          bool accelerate);

// mode=typecast: TYPE.

Result<Operation> parse_typecast(std::string_view option);
TemplateSpec get_output(const Typecast& typecast, const TemplateSpec& in);
std::optional<TemplateSpec> find_input(const Typecast& typecast, const TemplateSpec& out);
std::shared_ptr<const Kernel> make_kernel(const Typecast& typecast, const TensorSpec& in,
                                          bool accelerate);

}  // namespace weir::transform
