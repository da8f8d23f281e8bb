// Which elements the configuration allows in pipelines ([element-restriction], specification 8.1).
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

// nullopt: every element is allowed. Each call reads the configuration again. An error where a file
// of it is there and cannot be read or parsed: whether it restricts elements is not known then.
Result<std::optional<ElementRestriction>> element_restriction();

}  // namespace weir::application
