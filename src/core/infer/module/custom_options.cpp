// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/custom_options.hpp"

#include "core/text/text.hpp"

namespace weir::infer {

std::vector<std::pair<std::string, std::string>> custom_options(std::string_view custom) {
  std::vector<std::pair<std::string, std::string>> out;
  for (const auto part : split(custom, ",")) {
    const auto text = strip(part);
    if (text.empty()) continue;
    const size_t colon = text.find(':');
    const auto value =
        colon == std::string_view::npos ? std::string_view{} : text.substr(colon + 1);
    out.emplace_back(strip(text.substr(0, colon)), strip(value));
  }
  return out;
}

}  // namespace weir::infer
