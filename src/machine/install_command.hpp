// install_command: what brings a part of Weir that is not installed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string_view>

namespace weir {

// For errors. `package` is the command for a Weir that came as Debian packages (-Dpackages=true),
// `source` the one for a Weir that was built here.
constexpr std::string_view install_command([[maybe_unused]] std::string_view package,
                                           [[maybe_unused]] std::string_view source) noexcept {
#ifdef WEIR_PACKAGES
  return package;
#else
  return source;
#endif
}

// What brings a part that is always there.
constexpr std::string_view kInstallWeir =
    install_command("apt-get install --reinstall gstreamer1.0-weir", "make install");

}  // namespace weir
