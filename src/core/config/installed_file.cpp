// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/config/installed_file.hpp"

#include <filesystem>

#include "core/config/install_paths.hpp"

namespace weir::config {

namespace fs = std::filesystem;

std::string file_below(const std::string& data_folder, std::string_view path) {
  constexpr std::string_view kFolder = "/share/weir/";
  const size_t at = path.rfind(kFolder);
  if (at == std::string_view::npos) return "";
  const fs::path file = fs::path(data_folder) / path.substr(at + kFolder.size());
  std::error_code ignored;
  if (file == path || !fs::is_regular_file(file, ignored)) return "";
  return file.string();
}

std::string installed_file(const std::string& path) {
  std::error_code ignored;
  if (fs::exists(path, ignored)) return "";
  return file_below(fs::path(kInstalledCards).parent_path().string(), path);
}

}  // namespace weir::config
