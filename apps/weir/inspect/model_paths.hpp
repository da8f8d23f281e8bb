// Parses the argument MODEL: one file, or several separated by commas.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "core/text/text.hpp"

namespace weir::app {

inline std::vector<std::string> split_paths(const std::string& model) {
  std::vector<std::string> out;
  for (const auto part : split(model, ","))
    if (!strip(part).empty()) out.emplace_back(strip(part));
  return out;
}

}  // namespace weir::app
