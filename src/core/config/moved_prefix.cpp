// Compares paths as texts.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/config/moved_prefix.hpp"

namespace weir::config {

std::string prefix_of(std::string_view file, std::span<const std::string_view> folders,
                      std::string_view built_for) {
  const size_t slash = file.rfind('/');
  if (slash == std::string_view::npos || !file.starts_with('/')) return std::string(built_for);
  const std::string_view folder = file.substr(0, slash);
  for (const auto relative : folders) {
    const bool is_there = !relative.empty() && folder.ends_with(relative) &&
                          folder.size() > relative.size() &&
                          folder[folder.size() - relative.size() - 1] == '/';
    if (!is_there) continue;
    const auto prefix = folder.substr(0, folder.size() - relative.size() - 1);
    return prefix.empty() ? "/" : std::string(prefix);
  }
  return std::string(built_for);
}

std::string below_prefix(std::string_view path, std::string_view built_for,
                         std::string_view prefix) {
  const bool is_below = path.size() > built_for.size() && path.starts_with(built_for) &&
                        (path[built_for.size()] == '/' || built_for.ends_with('/'));
  if (!is_below) return std::string(path);
  std::string_view rest = path.substr(built_for.size());
  while (rest.starts_with('/')) rest.remove_prefix(1);
  return std::string(prefix) + (prefix.ends_with('/') ? "" : "/") + std::string(rest);
}

}  // namespace weir::config
