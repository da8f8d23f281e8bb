// Install paths: what meson.build passes to this file alone, below the prefix of this program or
// library.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/config/install_paths.hpp"

#include <dlfcn.h>

#include <array>
#include <deque>
#include <filesystem>
#include <string>

#include "core/config/moved_prefix.hpp"

namespace weir::config {
namespace {

// The file that has this code; "" where it cannot be found out.
std::string own_file() {
  static constexpr char kHere = 0;
  Dl_info info{};
  if (dladdr(&kHere, &info) == 0 || !info.dli_fname) return "";
  // Of the program itself, this is the name by which it was started.
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
  static const std::string prefix = prefix_of(own_file(), kFolders, WEIR_PREFIX);
  static auto& kept = *new std::deque<std::string>;  // outlives every reader
  return kept.emplace_back(below_prefix(path, WEIR_PREFIX, prefix)).c_str();
}

}  // namespace

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
