// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/filter/layout_list.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "core/text/text.hpp"
#include "weir/abi.h"
#include "weir/join.hpp"

namespace weir {

std::vector<uint32_t> parse_layout_list(std::string_view text, const std::string& property,
                                        std::optional<Error>* warning) {
  static constexpr std::array<std::pair<std::string_view, uint32_t>, 4> kLayoutNames{
      {{"NCHW", WEIR_LAYOUT_NCHW},
       {"NHWC", WEIR_LAYOUT_NHWC},
       {"ANY", WEIR_LAYOUT_ANY},
       {"NONE", WEIR_LAYOUT_NONE}}};
  std::vector<uint32_t> out;
  if (strip(text).empty()) return out;
  for (const auto part : split(text, ",.")) {
    const auto name = strip(part);
    const auto known =
        std::find_if(kLayoutNames.begin(), kLayoutNames.end(),
                     [name](const auto& entry) { return equal_ignoring_case(entry.first, name); });
    out.push_back(known == kLayoutNames.end() ? uint32_t{WEIR_LAYOUT_NONE} : known->second);
    if (known == kLayoutNames.end() && warning && !*warning)
      *warning = Error{.code = Code::OPTION_VALUE,
                       .what = "a layout is unknown and is treated as NONE",
                       .offered = property + "=" + std::string(text),
                       .needed = "NCHW, NHWC, ANY or NONE for each tensor",
                       .difference = "at \"" + std::string(name) + "\"",
                       .fix = property + "=NHWC"};
  }
  return out;
}

std::string layouts_text(std::span<const uint32_t> layouts) {
  static constexpr const char* kNames[] = {"ANY", "NHWC", "NCHW", "NONE"};
  return join(layouts, ",", [](const uint32_t layout) {
    return kNames[std::min<uint32_t>(layout, WEIR_LAYOUT_NONE)];
  });
}

void set_layouts(const std::vector<uint32_t>& layouts, std::vector<ModelTensor>* shapes) {
  for (size_t i = 0; i < std::min(layouts.size(), shapes->size()); ++i)
    if (layouts[i] != WEIR_LAYOUT_ANY) (*shapes)[i].layout = layouts[i];
}

}  // namespace weir
