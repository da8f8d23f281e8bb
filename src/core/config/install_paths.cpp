// Install paths: what meson.build passes to this file alone, below the prefix of this program or
// library.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/config/install_paths.hpp"

#include <dlfcn.h>

#include <array>
#include <deque>
#include <filesystem>
#include <string>

namespace weir::config {
namespace {

// The file that has this code; "" where it cannot be found out.
std::string own_file() {
  static constexpr char kHere = 0;
  Dl_info info{};
  if (dladdr(&kHere, &info) == 0 || !info.dli_fname) return "";
  // For the program itself, this is the name by which it was started.
  std::error_code failed;
  const std::string name = info.dli_fname;
  const auto file = std::filesystem::canonical(
      name.find('/') == std::string::npos ? "/proc/self/exe" : name, failed);
  return failed ? "" : file.string();
}

// The path below the prefix to which the tree was moved.
const char* installed(const char* path) {
  static constexpr std::array<std::string_view, 4> kFolders{
      WEIR_PLUGIN_FOLDER, WEIR_LIBRARY_FOLDER, WEIR_PROGRAM_FOLDER, WEIR_WORKER_FOLDER};
  static const std::string prefix = find_prefix(own_file(), kFolders, WEIR_PREFIX);
  static auto& kept = *new std::deque<std::string>;  // outlives every reader
  return kept.emplace_back(below_prefix(path, WEIR_PREFIX, prefix)).c_str();
}

}  // namespace

std::string find_prefix(std::string_view file, std::span<const std::string_view> folders,
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

const char* const kInstalledModules = installed(WEIR_MODULE_DIR);
const char* const kInstalledFilters = installed(WEIR_FILTER_DIR);
const char* const kInstalledCards = installed(WEIR_DATA_DIR "/cards");
const char* const kInstalledSettings = installed(WEIR_CONFIG_DIR);
const char* const kInstalledWorker = installed(WEIR_WORKER_PROGRAM);
const char* const kInstalledNnstreamer = installed(WEIR_NNSTREAMER_LIBRARY);

const char* installed_documents() {
  static const char* const folder = installed(WEIR_DOC_DIR);
  return folder;
}

const char* const kVersion = WEIR_VERSION;

}  // namespace weir::config
