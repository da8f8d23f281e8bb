// The settings of weir.ini, by name.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string>
#include <string_view>

namespace weir::config {

struct KnownSetting {
  std::string_view group;
  std::string_view key;  // one that ends in _ has more behind it: priority_tflite
  std::string_view help;
};

std::span<const KnownSetting> known_settings() noexcept;
bool is_known(std::string_view group, std::string_view key) noexcept;
// "[filter] priority_..." of the nearest known one; "" when none is near.
std::string nearest_known(std::string_view group, std::string_view key);

}  // namespace weir::config
