// The properties inputlayout and outputlayout (specification 4.1).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/filter/model_shape.hpp"

namespace weir {

// "NCHW,any": numbers of weir_layout, one for each part between commas or dots, in any case. What
// is not known is NONE, and `warning` (may be null) names the first such word.
std::vector<uint32_t> parse_layout_list(std::string_view text, const std::string& property,
                                        std::optional<Error>* warning = nullptr);
// Lays them over what the model says; ANY leaves that as it is.
void set_layouts(const std::vector<uint32_t>& layouts, std::vector<ModelShape>* shapes);

}  // namespace weir
