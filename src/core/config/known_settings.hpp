// The table of settings that weir.ini accepts.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string>
#include <string_view>

namespace weir::config {

struct KnownSetting {
  std::string_view group;
  std::string_view key;  // a key that ends in _ takes a suffix: priority_tflite
  std::string_view help;
};

std::span<const KnownSetting> known_settings() noexcept;
bool is_known(std::string_view group, std::string_view key) noexcept;
// "[filter] priority_..." for the nearest known setting; "" if none is similar.
std::string nearest_known(std::string_view group, std::string_view key);

}  // namespace weir::config
