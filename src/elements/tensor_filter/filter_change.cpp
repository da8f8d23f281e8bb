// Lists the properties that decide which model is opened.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/filter_change.hpp"

#include <algorithm>

#include "core/tensor/frame_spec.hpp"

namespace weir {
bool requires_reopen(std::string_view property) {
  static constexpr std::string_view kNames[] = {"framework",
                                                "input",
                                                "inputtype",
                                                "inputname",
                                                "inputlayout",
                                                "output",
                                                "outputtype",
                                                "outputname",
                                                "outputlayout",
                                                "custom",
                                                "accelerator",
                                                "input-combination",
                                                "output-combination",
                                                "shared-tensor-filter-key",
                                                "invoke-dynamic",
                                                "invoke-async",
                                                "suspend"};
  return std::ranges::find(kNames, property) != std::end(kNames);
}

Status check_lists(const FilterSettings& s) {
  for (const auto* text : {&s.input, &s.output})
    if (!text->empty())
      if (const auto shapes = parse_shape_list(*text); !shapes) return shapes.error();
  for (const auto* text : {&s.inputtype, &s.outputtype})
    if (!text->empty())
      if (const auto types = parse_type_list(*text); !types) return types.error();
  return ok();
}

}  // namespace weir
