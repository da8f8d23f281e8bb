// Defines the table of settings.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/config/known_settings.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "core/text/text.hpp"

namespace weir::config {
namespace {

constexpr std::array kSettings{
    KnownSetting{"filter", "priority_",
                 "engines for files with this extension, in order of preference"},
    KnownSetting{"filter", "path", "folders with libraries that provide filters by name"},
    KnownSetting{"filter", "enable_symlink", "a filter's file may be a symbolic link"},
    KnownSetting{"lua", "sandbox", "Lua scripts cannot access files, programs and libraries"},
    KnownSetting{"module", "path", "folders with modules, searched before the built-in one"},
    KnownSetting{"plugin", "prefer_nnstreamer",
                 "Weir does not register elements whose names NNStreamer has"},
    KnownSetting{"network", "require-tls",
                 "elements with protocols of NNStreamer need TLS for other machines"},
    KnownSetting{"nnstreamer", "enable", "nnstreamer.ini and sub-plugins for NNStreamer are used"},
    KnownSetting{"nnstreamer", "library", "the file with the functions that sub-plugins call"},
};

bool matches(const KnownSetting& known, std::string_view key) {
  if (!known.key.ends_with('_')) return key == known.key;
  return key.starts_with(known.key) && key.size() > known.key.size();
}

}  // namespace

std::span<const KnownSetting> known_settings() noexcept {
  return kSettings;
}

bool is_known(std::string_view group, std::string_view key) noexcept {
  return std::any_of(kSettings.begin(), kSettings.end(), [&](const auto& known) {
    return known.group == group && matches(known, key);
  });
}

std::string nearest_known(std::string_view group, std::string_view key) {
  // Users choose the file extension after the underscore, so only the part before it is compared.
  const size_t underscore = key.rfind('_');
  const bool ends = underscore != std::string_view::npos && underscore + 1 < key.size();
  std::vector<std::string> candidates;
  for (const auto& known : kSettings) {
    std::string whole = std::string(known.group) + "/" + std::string(known.key);
    if (known.key.ends_with('_') && ends) whole += key.substr(underscore + 1);
    candidates.push_back(std::move(whole));
  }
  const std::string close = nearest(std::string(group) + "/" + std::string(key), candidates);
  const size_t slash = close.find('/');
  return close.empty() ? "" : "[" + close.substr(0, slash) + "] " + close.substr(slash + 1);
}

}  // namespace weir::config
