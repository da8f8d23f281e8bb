// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/subplugin/loader.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <map>
#include <mutex>
#include <set>

#include "core/config/install_paths.hpp"
#include "core/infer/module/accelerator.hpp"
#include "core/infer/module/engine_functions.hpp"
#include "core/infer/module/host.hpp"
#include "core/infer/module/load_configuration.hpp"
#include "core/infer/module/module_check.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/process/process_object.hpp"
#include "core/text/shell_quote.hpp"

namespace weir::subplugin {
namespace {

namespace fs = std::filesystem;

config::FolderKind folder_kind(Kind kind) {
  switch (kind) {
    case Kind::Filter:
      return config::FolderKind::Filters;
    case Kind::Decoder:
      return config::FolderKind::Decoders;
    case Kind::Converter:
      return config::FolderKind::Converters;
    case Kind::Trainer:
      return config::FolderKind::Trainers;
  }
  return config::FolderKind::Filters;
}

std::string get_prefix(Kind kind) {
  return std::string("libnnstreamer_") + to_string(kind) + "_";
}

// The directory entry of that name in one folder.
enum class Entry { None, File, ForbiddenLink };
Entry entry(const fs::path& path, bool links) {
  std::error_code failed;
  if (!fs::is_regular_file(path, failed)) return Entry::None;
  return fs::is_symlink(path, failed) && !links ? Entry::ForbiddenLink : Entry::File;
}

// The first allowed file, or a forbidden link if no folder has a file.
struct Found {
  std::string file, forbidden_link;
};
Found look_for(Kind kind, std::string_view name) {
  Found found;
  if (name.empty() || name.find('/') != std::string_view::npos) return found;
  const auto configuration = infer::nnstreamer_configuration();
  for (const auto& folder : configuration.folders(folder_kind(kind))) {
    const fs::path path = fs::path(folder.path) / (get_prefix(kind) + std::string(name) + ".so");
    const Entry which = entry(path, configuration.enable_symlink());
    if (which == Entry::ForbiddenLink && found.forbidden_link.empty())
      found.forbidden_link = path.string();
    if (which != Entry::File) continue;
    found.file = path.string();
    break;
  }
  return found;
}

std::string last_reason() {
  const char* reason = dlerror();
  return reason ? reason : "dlopen failed";
}

Error link_forbidden(const std::string& path) {
  std::error_code ignored;
  const auto target = fs::canonical(path, ignored).string();
  return Error{
      .code = Code::MODULE_REFUSED,
      .what = "a sub-plugin's file must not be a symbolic link",
      .offered = path + " -> " + target,
      .needed = "the file itself, or enable_symlink=true in the group [common] of nnstreamer.ini",
      .fix = "cp --remove-destination " + shell_word(target) + " " + shell_word(path)};
}

// Keeps the reason for rejecting a file, since its constructor runs only once.
struct Refused {
  std::mutex mutex;  // guards the rest
  std::map<std::string, Error> reasons;
  std::set<std::string> reported;
};
Refused& refused() {
  static auto& all = process::object<Refused>("nnstreamer-refused-files");
  return all;
}

Result<const void*> load(Kind kind, std::string_view name, const std::string& file) {
  if (auto status = load_library(); !status) return status.error();
  const Table::Recording recording(table());
  if (!dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL))
    return infer::module_not_loaded(file, dlerror());
  if (const void* found = table().find(kind, name)) return found;
  const std::string registered = recording.to_string();
  const bool was_rejected = registered.find("rejected") != std::string::npos;
  const Error error{.code = Code::MODULE_REFUSED,
                    .what = "the sub-plugin " + file + " does not register itself",
                    .offered = registered,
                    .needed = "the " + std::string(to_string(kind)) + " " + std::string(name) +
                              ", registered when the file is loaded",
                    .fix = was_rejected ? "correct the rejected part and rebuild the file"
                                        : "the file's name must be " + get_prefix(kind) +
                                              "NAME.so with the registered NAME"};
  std::lock_guard lock(refused().mutex);
  return refused().reasons.try_emplace(file, error).first->second;
}

struct Adapter {
  std::atomic<EngineAdapter> function{nullptr};
};
std::atomic<EngineAdapter>& engine_adapter() {
  static auto& adapter = process::object<Adapter>("nnstreamer-engine-adapter");
  return adapter.function;
}

struct Check {
  std::atomic<HardwareCheck> function{nullptr};
};
std::atomic<HardwareCheck>& hardware_check() {
  static auto& check = process::object<Check>("nnstreamer-hardware-check");
  return check.function;
}

// Returns the filter that the engine runs; null for an engine of Weir.
const void* find_descriptor(const weir_engine& engine) {
  const void* descriptor = table().find(Kind::Filter, engine.name);
  const auto adapter = engine_adapter().load();
  return descriptor && adapter && adapter(descriptor) == &engine ? descriptor : nullptr;
}

// An engine without a list runs on the CPU.
bool runs_on(const weir_engine& engine, unsigned hardware) {
  const auto names = infer::list_accelerators(engine);
  if (names.empty()) return hardware == infer::accelerator_number("cpu");
  return std::any_of(names.begin(), names.end(), [hardware](const std::string& name) {
    return infer::accelerator_number(name) == hardware;
  });
}

}  // namespace

std::string library_path() {
  const auto setting = infer::configuration().find("nnstreamer", "library");
  return setting ? setting->value : config::kInstalledNnstreamer;
}

Status load_library() {
  const std::string library = library_path();
  // dlopen searches for bare names, and opens the program itself for an empty one.
  if (!fs::path(library).is_absolute())
    return Error{
        .code = Code::OPTION_VALUE,
        .what = "the path of the library with NNStreamer's functions is not absolute",
        .offered = "\"" + library + "\"",
        .needed = "the absolute path of a file, in [nnstreamer] library or WEIR_NNSTREAMER_LIBRARY",
        .fix = std::string("WEIR_NNSTREAMER_LIBRARY=") + config::kInstalledNnstreamer};
  void* handle = dlopen(library.c_str(), RTLD_NOW | RTLD_GLOBAL);
  if (!handle)
    return Error{
        .code = Code::MODULE_REFUSED,
        .what =
            "the library with the functions that sub-plugins for NNStreamer call cannot be "
            "opened",
        .offered = last_reason(),
        .needed = library,
        .fix = "install it, or name it: WEIR_NNSTREAMER_LIBRARY=/path/to/libnnstreamer.so"};
  constexpr char kFunction[] = "nnstreamer_filter_probe";
  if (dlsym(RTLD_DEFAULT, kFunction) != dlsym(handle, kFunction))
    return Error{.code = Code::MODULE_REFUSED,
                 .what = "another library of this process has NNStreamer's functions already",
                 .offered = kFunction,
                 .needed = "those of " + library,
                 .fix = "run the pipeline without NNStreamer's own plug-in and libraries"};
  return ok();
}

Result<const void*> open(Kind kind, std::string_view name) {
  if (const void* known = table().find(kind, name)) return known;
  const Found found = look_for(kind, name);
  if (!found.file.empty()) return load(kind, name, found.file);
  if (!found.forbidden_link.empty()) return link_forbidden(found.forbidden_link);
  return nullptr;
}

void open_all(Kind kind) {
  for (const auto& name : available(kind))
    if (const auto opened = open(kind, name); !opened)
      log_once(get_prefix(kind) + name, opened.error().message());
}

void log_once(const std::string& who, const std::string& message) {
  {
    std::lock_guard lock(refused().mutex);
    if (!refused().reported.insert(who + ": " + message).second) return;
  }
  infer::host().log(WEIR_LOG_WARNING, who.c_str(), message.c_str());
}

std::string find_file(Kind kind, std::string_view name) {
  return look_for(kind, name).file;
}

std::vector<std::string> available(Kind kind) {
  const auto registered = table().names(kind);
  std::set<std::string> out(registered.begin(), registered.end());
  const std::string prefix = get_prefix(kind);
  const auto configuration = infer::nnstreamer_configuration();
  for (const auto& folder : configuration.folders(folder_kind(kind))) {
    std::error_code ignored;
    for (const auto& each : fs::directory_iterator(folder.path, ignored)) {
      const std::string file = each.path().filename().string();
      if (file.size() > prefix.size() + 3 && file.starts_with(prefix) && file.ends_with(".so") &&
          entry(each.path(), configuration.enable_symlink()) == Entry::File)
        out.insert(file.substr(prefix.size(), file.size() - prefix.size() - 3));
    }
  }
  return {out.begin(), out.end()};
}

void set_engine_adapter(EngineAdapter adapter) noexcept {
  engine_adapter() = adapter;
}

Result<const weir_engine*> engine(std::string_view name) {
  const auto descriptor = open(Kind::Filter, name);
  if (!descriptor) return descriptor.error();
  if (!*descriptor) return nullptr;
  const auto adapter = engine_adapter().load();
  const weir_engine* engine = adapter ? adapter(*descriptor) : nullptr;
  if (!engine)
    return Error{
        .code = Code::MODULE_REFUSED,
        .what = "the filter " + std::string(name) + " for NNStreamer cannot be used as an engine",
        .offered = adapter ? "see the log for the reason"
                           : "this process cannot run filters for NNStreamer",
        .needed = "a filter of the interface V0 or V1"};
  return engine;
}

void set_hardware_check(HardwareCheck check) noexcept {
  hardware_check() = check;
}

Status check_available(std::string_view name, unsigned hardware, const char* custom) {
  const auto engine = infer::ModuleLibrary::instance().engine(name);
  if (!engine) return engine.error();
  const auto extension = infer::get_function(**engine, &weir_engine::extension);
  const auto* const problem =
      static_cast<const char* const*>(extension ? extension("weir.library-problem/1") : nullptr);
  if (problem)
    return Error{.code = Code::ENGINE_NOT_INSTALLED,
                 .what = "the engine " + std::string(name) + " lacks a library",
                 .offered = problem[0],
                 .needed = "that library",
                 .fix = problem[1]};
  if (hardware == infer::accelerator_number("auto") ||
      hardware == infer::accelerator_number("default"))
    return ok();
  const void* const descriptor = find_descriptor(**engine);
  const auto check = hardware_check().load();
  const bool runs =
      descriptor && check ? check(descriptor, hardware, custom) : runs_on(**engine, hardware);
  if (runs) return ok();
  return Error{.code = Code::OPTION_VALUE,
               .what = "the framework " + std::string(name) + " does not run on this hardware"};
}

}  // namespace weir::subplugin
