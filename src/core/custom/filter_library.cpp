// Opens a file with dlopen after inspecting its symbol names.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/custom/filter_library.hpp"

#include <dlfcn.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>

#include "core/config/install_paths.hpp"
#include "core/infer/module/host.hpp"
#include "core/infer/module/load_configuration.hpp"
#include "core/infer/module/model_file.hpp"
#include "core/infer/module/module_check.hpp"
#include "core/process/process_object.hpp"
#include "core/subplugin/loader.hpp"
#include "core/text/shell_quote.hpp"
#include "core/text/text.hpp"

namespace weir::custom {
namespace {

namespace fs = std::filesystem;
using infer::ModuleTables;

struct Libraries {
  std::mutex mutex;                                             // guards opened
  std::map<void*, std::shared_ptr<const ModuleTables>> opened;  // by handle; null: no entry
};
Libraries& libraries() {
  static auto& all = process::object<Libraries>("filter-libraries");
  return all;
}

// The symbol names that the file contains. Read in chunks, since a file may have any size.
struct Names {
  bool shared_object = false, entry = false, registers = false;
  bool callbacks = false, calls_nnstreamer = false, probes = false;  // NNStreamer's interface
};
Names names_in(const std::string& path) {
  constexpr size_t kPiece = 1 << 20, kOverlap = 64;
  constexpr uint64_t kMax = uint64_t{1} << 30;
  Names found;
  std::ifstream file(path, std::ios::binary);
  std::string piece;
  for (uint64_t read = 0; file && read < kMax; read += kPiece) {
    const std::string tail = piece.substr(piece.size() - std::min(piece.size(), kOverlap));
    piece.assign(kPiece, '\0');
    file.read(piece.data(), static_cast<std::streamsize>(kPiece));
    piece.resize(static_cast<size_t>(file.gcount()));
    piece.insert(0, tail);
    if (read == 0) found.shared_object = piece.starts_with("\177ELF");
    const auto has = [&](const char* name) { return piece.find(name) != std::string::npos; };
    found.entry = found.entry || has("weir_module_entry");
    found.registers =
        found.registers || has("weir_filter_class_register") || has("weir_filter_register");
    found.callbacks = found.callbacks || has("NNStreamer_custom");
    found.probes = found.probes || has("nnstreamer_filter_probe");
    found.calls_nnstreamer =
        found.calls_nnstreamer || has("NNS_custom_easy_") || has("tensor_filter_cpp10__register");
  }
  return found;
}

bool links_are_allowed() {
  const auto setting = infer::configuration().find("filter", "enable_symlink");
  if (setting) return config::truth(setting->value, false);
  return infer::nnstreamer_configuration().enable_symlink();
}

Result<Names> check_file(const std::string& path) {
  if (auto status = infer::check_model_file(path); !status) return status.error();
  std::error_code ignored;
  if (fs::is_symlink(path, ignored) && !links_are_allowed()) {
    const auto target = fs::canonical(path, ignored).string();
    return Error{
        .code = Code::MODULE_REFUSED,
        .what = "a filter's file must not be a symbolic link",
        .offered = path + " -> " + target,
        .needed = "the file itself, or enable_symlink=true in the group [filter] of weir.ini",
        .fix = "model=" + launch_value(target)};
  }
  const auto names = names_in(path);
  if (names.entry || names.registers || names.callbacks || names.calls_nnstreamer) return names;
  return Error{
      .code = Code::MODULE_REFUSED,
      .what = "the file " + path + " contains no filter",
      .offered = names.shared_object ? "no symbol weir_module_entry and no NNStreamer_custom"
                                     : "not a shared object: it has no symbol weir_module_entry",
      .needed =
          "a shared object that exports weir_module_entry, as WEIR_ENGINE does, or "
          "NNStreamer_custom",
      .fix = names.probes ? "framework=NAME, if the sub-plugin libnnstreamer_filter_NAME.so is in "
                            "a folder that weir doctor lists"
                          : "weir new filter --language c++ NAME"};
}

bool has_callbacks_alone(const Names& names) {
  return names.callbacks && !names.entry && !names.registers && !names.calls_nnstreamer;
}

Error callbacks_alone(const std::string& path) {
  return Error{.code = Code::MODULE_REFUSED,
               .what = "the file has one filter without a name, for framework=custom",
               .offered = path + " exports NNStreamer_custom",
               .needed = "a shared object that registers filters by name",
               .fix = "framework=custom model=" + launch_value(path)};
}

}  // namespace

Result<bool> has_callbacks(const std::string& path) {
  const auto names = check_file(path);
  if (!names) return names.error();
  return has_callbacks_alone(*names);
}

Result<std::shared_ptr<const ModuleTables>> open_filter_library(const std::string& path) {
  const auto names = check_file(path);
  if (!names) return names.error();
  if (has_callbacks_alone(*names)) return callbacks_alone(path);
  if (names->calls_nnstreamer)
    if (auto status = subplugin::load_library(); !status) return status.error();
  std::error_code ignored;
  const std::string file = fs::absolute(path, ignored).string();  // dlopen searches for bare names
  // Without the lock: a constructor in the file may open other files.
  void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle) return infer::module_not_loaded(path, dlerror());
  auto& all = libraries();
  {
    std::lock_guard lock(all.mutex);
    if (const auto known = all.opened.find(handle); known != all.opened.end()) return known->second;
  }
  using Entry = const weir_module* (*)(const weir_host*);
  const auto entry = reinterpret_cast<Entry>(dlsym(handle, "weir_module_entry"));
  std::shared_ptr<const ModuleTables> tables;
  if (entry) {
    auto copied = ModuleTables::copy(entry(&infer::host()), path);
    if (!copied) return copied.error();
    tables = *std::move(copied);
  }
  std::lock_guard lock(all.mutex);
  return all.opened.try_emplace(handle, std::move(tables)).first->second;
}

std::vector<std::string> filter_folders() {
  std::vector<std::string> out;
  if (const auto folders = infer::configuration().find("filter", "path"))
    for (const auto part : split(folders->value, ":"))
      if (!part.empty()) out.emplace_back(part);
  out.emplace_back(config::kInstalledFilters);
  const auto nnstreamer = infer::nnstreamer_configuration();
  for (const auto& folder : nnstreamer.folders(config::FolderKind::CustomFilters))
    out.push_back(folder.path);
  return out;
}

std::string library_of_filter(const std::string& name) {
  if (name.empty() || name.find('/') != std::string::npos) return "";
  for (const auto& folder : filter_folders()) {
    std::error_code ignored;
    const fs::path path = fs::path(folder) / (name + ".so");
    if (fs::is_regular_file(path, ignored)) return path.string();
  }
  return "";
}

}  // namespace weir::custom
