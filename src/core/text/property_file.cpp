// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/property_file.hpp"

#include "core/text/text.hpp"

namespace weir {

std::vector<std::pair<std::string_view, std::string_view>> parse_property_file(
    std::string_view text) {
  std::vector<std::pair<std::string_view, std::string_view>> out;
  for (const auto line : split(text, "\n")) {
    const size_t sign = line.find('=');
    if (sign == std::string_view::npos) continue;
    const auto key = strip(line.substr(0, sign));
    if (!key.empty()) out.emplace_back(key, strip(line.substr(sign + 1)));
  }
  return out;
}

}  // namespace weir
