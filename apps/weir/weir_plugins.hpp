// The plug-ins of Weir, by the names that GStreamer knows them by.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string_view>

namespace weir::app {

constexpr bool is_weir_plugin(std::string_view name) noexcept {
  return name == "weir" || name == "weiredge" || name == "weirnet";
}

}  // namespace weir::app
