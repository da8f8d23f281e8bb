// The elements that the configuration allows ([element-restriction],
// docs/compatibility/app-api.md 8.1).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "weir/result.hpp"

namespace weir::application {

struct ElementRestriction {
  std::vector<std::string> allowed;
  std::string origin;  // "/etc/nnstreamer.ini:7"
};

// nullopt: every element is allowed. Each call reads the configuration again. An error when a
// configuration file exists and cannot be read or parsed, because it may restrict elements.
Result<std::optional<ElementRestriction>> element_restriction();

}  // namespace weir::application
