// Which elements the configuration allows in pipelines ([element-restriction], specification 8.1).
#pragma once
#include <optional>
#include <string>
#include <vector>

namespace weir::application {

struct ElementRestriction {
  std::vector<std::string> allowed;
  std::string origin;  // "/etc/nnstreamer.ini:7"
};

// nullopt: every element is allowed. Read anew with each call.
std::optional<ElementRestriction> element_restriction();

}  // namespace weir::application
