// [element-restriction] of nnstreamer.ini and of NNSTREAMER_element-restriction_KEY.
#include "element_restriction.hpp"

#include "core/config/ini.hpp"
#include "core/config/nnstreamer.hpp"
#include "core/text/text.hpp"

namespace weir::application {

std::optional<ElementRestriction> element_restriction() {
  constexpr const char* kGroup = "element-restriction";
  const auto configuration = config::NnstreamerConfiguration::load();
  const auto enabled = configuration.find(kGroup, "enable_element_restriction");
  if (!enabled || !config::truth(enabled->value, false)) return std::nullopt;
  ElementRestriction out{{}, enabled->origin};
  const auto elements = configuration.find(kGroup, "restricted_elements");
  if (!elements) return out;
  out.origin = elements->origin;
  for (const auto word : split(elements->value, ",; "))
    if (!strip(word).empty()) out.allowed.emplace_back(strip(word));
  return out;
}

}  // namespace weir::application
