// The properties inputlayout and outputlayout (docs/compatibility/filter.md 4.1).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/filter/model_fit.hpp"

namespace weir {

// "NCHW,any": one weir_layout for each part between commas or dots; ignores case. Unknown names
// become NONE, and `warning` (may be null) gets an error for the first one.
std::vector<uint32_t> parse_layout_list(std::string_view text, const std::string& property,
                                        std::optional<Error>* warning = nullptr);
// The layouts as text; of a list, as it was parsed.
std::string layouts_text(std::span<const uint32_t> layouts);
inline std::string layouts_text(const std::string& list) {
  return layouts_text(parse_layout_list(list, "layout"));
}
// Overrides the model's layouts; ANY keeps the model's.
void set_layouts(const std::vector<uint32_t>& layouts, std::vector<ModelTensor>* shapes);

}  // namespace weir
