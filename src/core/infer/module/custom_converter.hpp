// Converter functions of the application, by name: weir/custom_converter.h.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>
#include <string_view>

#include "core/infer/module/converter.hpp"

namespace weir::infer {

// A converter that looks `name` up at its first frame after configure: CONVERTER_UNKNOWN with the
// registered names.
std::unique_ptr<Converter> custom_converter(std::string name);
bool is_custom_converter(std::string_view name);

}  // namespace weir::infer
