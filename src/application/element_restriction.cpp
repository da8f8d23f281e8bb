// Reads [element-restriction] of nnstreamer.ini and NNSTREAMER_element-restriction_KEY.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "element_restriction.hpp"

#include <cstdio>
#include <mutex>

#include "core/config/ini.hpp"
#include "core/config/nnstreamer.hpp"
#include "core/text/text.hpp"

namespace weir::application {
namespace {

// Once per process.
void log_faults(const config::NnstreamerConfiguration& configuration) {
  static std::once_flag reported;
  if (configuration.faults().empty()) return;
  std::call_once(reported, [&configuration] {
    for (const auto& fault : configuration.faults())
      std::fprintf(stderr, "weir: configuration: %s\n", fault.message().c_str());
  });
}

}  // namespace

Result<std::optional<ElementRestriction>> element_restriction() {
  using None = std::optional<ElementRestriction>;
  constexpr const char* kGroup = "element-restriction";
  const auto configuration = config::NnstreamerConfiguration::load();
  if (const auto& unread = configuration.unread()) {
    Error error = *unread;
    error.what = "a pipeline cannot be checked against [element-restriction]: " + error.what;
    return error;
  }
  log_faults(configuration);
  const auto enabled = configuration.find(kGroup, "enable_element_restriction");
  if (!enabled || !config::truth(enabled->value, false)) return None();
  ElementRestriction out{{}, enabled->origin};
  const auto elements = configuration.find(kGroup, "restricted_elements");
  if (!elements) return None(std::move(out));
  out.origin = elements->origin;
  for (const auto word : split(elements->value, ",; "))
    if (!strip(word).empty()) out.allowed.emplace_back(strip(word));
  return None(std::move(out));
}

}  // namespace weir::application
