// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/module_library.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <set>

#include "core/config/install_paths.hpp"
#include "core/infer/module/engine_functions.hpp"
#include "core/infer/module/host.hpp"
#include "core/infer/module/known_engines.hpp"
#include "core/infer/module/load_configuration.hpp"
#include "core/infer/module/module_check.hpp"
#include "core/text/text.hpp"
#include "machine/install_command.hpp"
#include "weir/join.hpp"

namespace weir::infer {
namespace {

namespace fs = std::filesystem;

std::string file_name(const std::string& kind, const std::string& name) {
  return "libweir-" + kind + "-" + name + ".so";
}

// Whether a module can have this name: a path is none.
bool is_plain(std::string_view name) {
  return !name.empty() && name.find('/') == std::string_view::npos;
}

std::string list(const std::vector<std::string>& text) {
  const std::string out = join(text, ", ");
  return out.empty() ? "none" : out;
}

// The error for an engine of the table that has no module here.
Error not_installed(const KnownEngine& known, std::string_view word, std::string installed) {
  const std::string name(known.name);
  Error out{.code = Code::ENGINE_NOT_INSTALLED,
            .what = "the engine " + name + " is not installed",
            .offered = "framework=" + std::string(word),
            .needed = "one of: " + std::move(installed)};
  if (!known.install.empty()) {
    out.fix = std::string(known.install);
    return out;
  }
  out.what = "Weir has no engine " + name;
  out.needed = known.alternative.empty() ? "" : std::string(known.alternative) + ", or ";
  out.needed += "NNStreamer's sub-plugin libnnstreamer_filter_" + name + ".so";
  return out;
}

// Where sub-plugins of NNStreamer are searched for; "" if they are not.
std::string sub_plugin_folders() {
  const auto configuration = nnstreamer_configuration();
  return join(configuration.folders(config::FolderKind::Filters), " or ",
              [](const auto& folder) { return folder.path; });
}

// The error for a name that no table has: it is misspelt, or its module is in a folder that is not
// searched.
Error unknown_engine(std::string_view word, const std::vector<std::string>& available) {
  std::vector<std::string> candidates = available;
  for (const auto& engine : known_engines()) {
    candidates.emplace_back(engine.name);
    for (const auto alias : split(engine.aliases, ",")) candidates.emplace_back(alias);
  }
  const std::string close = nearest(word, candidates);
  Error out{.code = Code::ENGINE_UNKNOWN,
            .what = "no engine has this name",
            .offered = "framework=" + std::string(word),
            .needed = "one of: " + list(available),
            .difference = close.empty() ? "" : "did you mean " + close + "?",
            .fix = close.empty() ? "" : "framework=" + close};
  if (!is_plain(word)) return out;
  out.needed += "; or the file " + file_name("engine", std::string(word)) +
                " in a folder that WEIR_MODULE_PATH lists";
  if (const auto folders = sub_plugin_folders(); !folders.empty())
    out.needed +=
        ", or NNStreamer's libnnstreamer_filter_" + std::string(word) + ".so in " + folders;
  if (close.empty()) out.fix = "export WEIR_MODULE_PATH=/folder/of/the/module";
  return out;
}

template <class T>
const T* find_in(const T* const* tables, std::string_view name) {
  for (; tables && *tables; ++tables) {
    if ((*tables)->name == name) return *tables;
    const std::string_view aliases = (*tables)->aliases ? (*tables)->aliases : "";
    for (const auto alias : split(aliases, ","))
      if (!name.empty() && strip(alias) == name) return *tables;
  }
  return nullptr;
}

// Adds the install command if the module exists but a library it links is missing or has another
// version.
Error with_install_line(Error error, const KnownEngine& known) {
  const auto mentions = [&](const char* text) {
    return error.offered.find(text) != std::string::npos;
  };
  const bool is_missing = mentions("cannot open shared object file");
  const bool is_other = mentions("undefined symbol") || mentions("version `");
  if (known.install.empty() || (!is_missing && !is_other)) return error;
  return Error{.code = Code::ENGINE_NOT_INSTALLED,
               .what = "a library of the engine " + std::string(known.name) +
                       (is_missing ? " is not installed"
                                   : " differs from the one the module was built with"),
               .offered = error.offered,
               .needed = "the version of the library that the module was built with",
               .fix = std::string(known.install)};
}

// What brings a decoder or converter that is a part of its own; "" if there is none of this name.
std::string install_command_of_part(std::string_view name) {
  if (name == "protobuf")
    return std::string(install_command("apt-get install gstreamer1.0-weir-protobuf",
                                       "apt-get install libprotobuf-dev && make build"));
  if (name == "flatbuf" || name == "flexbuf")
    return std::string(
        install_command("apt-get install --reinstall gstreamer1.0-weir",
                        "apt-get install libflatbuffers-dev flatbuffers-compiler && make build"));
  const auto* engine = name == "python3" ? known_engine(name) : nullptr;
  return engine ? std::string(engine->install) : "";
}

// Other names for `framework=word` if no engine has that one (docs/compatibility/filter.md 4.2).
std::vector<std::string> engines_meant_by(std::string_view word) {
  const auto nnstreamer = nnstreamer_configuration();
  std::vector<std::string> out;
  const auto add = [&](std::string_view group, std::string_view key) {
    const auto setting = nnstreamer.find(group, key);
    if (!setting) return;
    for (const auto part : split(setting->value, " ,;"))
      if (const auto name = strip(part); !name.empty()) out.emplace_back(name);
  };
  add(word, "subplugin_priority");
  add("filter-aliases", word);
  return out;
}

// The names of the modules in a folder: "a" of the file PREFIXa.so.
void add_names_in(const std::string& folder, const std::string& prefix,
                  std::set<std::string>* names) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string file = entry.path().filename().string();
    if (file.starts_with(prefix) && file.ends_with(".so"))
      names->insert(file.substr(prefix.size(), file.size() - prefix.size() - 3));
  }
}

// The engine that a module has for this name, else its first one.
Result<const weir_engine*> engine_in(const weir_module& module, std::string_view word,
                                     const std::string& name) {
  if (const auto* table = find_in(module.engines, word)) return table;
  if (module.engines && module.engines[0]) return module.engines[0];
  return module_refused(file_name("engine", name), "it contains no engine", "one");
}

}  // namespace

std::vector<std::string> ModuleLibrary::search_path() {
  std::vector<std::string> out;
  if (const auto folders = configuration().find("module", "path"))
    for (const auto part : split(folders->value, ":"))
      if (!part.empty()) out.emplace_back(part);
  out.emplace_back(config::kInstalledModules);
  return out;
}

void ModuleLibrary::add_builtin(const weir_module* module) {
  std::lock_guard lock(mutex_);
  builtins_.push_back(module);
}

void ModuleLibrary::add_source(EngineSource source) {
  std::lock_guard lock(mutex_);
  sources_.push_back(source);
}

std::vector<EngineSource> ModuleLibrary::sources() const {
  std::lock_guard lock(mutex_);
  return sources_;
}

// Returns null without an error if there is no such file.
Result<const weir_module*> ModuleLibrary::open(const std::string& kind, const std::string& name) {
  for (const auto& folder : search_path()) {
    const std::string path = (fs::path(folder) / file_name(kind, name)).string();
    std::error_code ignored;
    if (!fs::is_regular_file(path, ignored)) continue;
    std::lock_guard lock(mutex_);
    const auto known = opened_.find(path);
    if (known != opened_.end()) return &known->second->module();
    void* handle = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!handle) return module_not_loaded(path, dlerror());
    using Entry = const weir_module* (*)(const weir_host*);
    const auto entry = reinterpret_cast<Entry>(dlsym(handle, "weir_module_entry"));
    if (!entry) return module_refused(path, "no symbol weir_module_entry", "that symbol, exported");
    auto tables = ModuleTables::copy(entry(&host()), path);
    if (!tables) return tables.error();
    return &opened_.emplace(path, *std::move(tables)).first->second->module();
  }
  return nullptr;
}

std::vector<std::string> ModuleLibrary::engine_names() const {
  std::vector<std::string> out = names("engine");
  for (const auto& source : sources())
    for (auto& name : source.names()) out.push_back(std::move(name));
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

std::vector<std::string> ModuleLibrary::names(const std::string& kind) const {
  std::set<std::string> out;
  for (const auto& folder : search_path()) add_names_in(folder, "libweir-" + kind + "-", &out);
  const auto add = [&out](auto tables) {
    for (; tables && *tables; ++tables) out.insert((*tables)->name);
  };
  std::lock_guard lock(mutex_);
  for (const auto* module : builtins_) {
    if (kind == "engine") add(module->engines);
    if (kind == "decoder") add(module->decoders);
    if (kind == "converter") add(module->converters);
  }
  return {out.begin(), out.end()};
}

// Returns null without an error if no engine has this name.
Result<const weir_engine*> ModuleLibrary::named_engine(std::string_view word) {
  {
    std::lock_guard lock(mutex_);
    for (const auto* module : builtins_)
      if (const auto* table = find_in(module->engines, word)) return table;
  }
  const KnownEngine* known = known_engine(word);
  const std::string name(known ? known->name : word);
  auto module = is_plain(name) ? open("engine", name) : Result<const weir_module*>(nullptr);
  if (!module) return known ? with_install_line(module.error(), *known) : module.error();
  if (*module) return engine_in(**module, word, name);
  for (const auto& source : sources()) {
    auto found = source.engine(word);
    if (!found || *found) return found;
  }
  return nullptr;
}

Result<const weir_engine*> ModuleLibrary::engine(std::string_view word) {
  auto found = named_engine(word);
  if (!found || *found) return found;
  const KnownEngine* known = known_engine(word);
  for (const auto& other : engines_meant_by(word)) {
    found = named_engine(other);
    if (!found || *found) return found;
  }
  if (known) return not_installed(*known, word, list(engine_names()));
  return unknown_engine(word, engine_names());
}

Result<const weir_engine*> ModuleLibrary::engine_for_model(std::span<const std::string> paths) {
  const auto choice = choose_engine(paths);
  return choice ? engine(choice->engine) : Result<const weir_engine*>(choice.error());
}

Result<EngineChoice> ModuleLibrary::choose_engine(std::span<const std::string> paths) const {
  const auto nnstreamer = nnstreamer_configuration();
  return infer::choose_engine(paths, engine_names(), configuration(), &nnstreamer);
}

Result<const weir_decoder_type*> ModuleLibrary::decoder(std::string_view name) {
  {
    std::lock_guard lock(mutex_);
    for (const auto* module : builtins_)
      if (const auto* table = find_in(module->decoders, name)) return table;
  }
  auto module =
      is_plain(name) ? open("decoder", std::string(name)) : Result<const weir_module*>(nullptr);
  if (!module) return module.error();
  if (*module)
    if (const auto* table = find_in((*module)->decoders, name)) return table;
  const auto available = decoder_names();
  const std::string close = nearest(name, available);
  std::string fix = install_command_of_part(name);
  if (fix.empty()) fix = close.empty() ? "gst-inspect-1.0 tensor_decoder" : "mode=" + close;
  return Error{.code = Code::DECODER_UNKNOWN,
               .what = "no decoder has this name",
               .offered = "mode=" + std::string(name),
               .needed = "one of: " + list(available),
               .difference = close.empty() ? "" : "did you mean " + close + "?",
               .fix = std::move(fix)};
}

Result<const weir_converter_type*> ModuleLibrary::converter(std::string_view name) {
  {
    std::lock_guard lock(mutex_);
    for (const auto* module : builtins_)
      if (const auto* table = find_in(module->converters, name)) return table;
  }
  auto module =
      is_plain(name) ? open("converter", std::string(name)) : Result<const weir_module*>(nullptr);
  if (!module) return module.error();
  if (*module)
    if (const auto* table = find_in((*module)->converters, name)) return table;
  std::string fix = install_command_of_part(name);
  if (fix.empty()) fix = "gst-inspect-1.0 tensor_converter";
  return Error{.code = Code::CONVERTER_UNKNOWN,
               .what = "no converter has this name",
               .offered = std::string(name),
               .needed = "one of: " + list(converter_names()),
               .fix = std::move(fix)};
}

std::vector<const weir_converter_type*> ModuleLibrary::converters() {
  std::vector<const weir_converter_type*> out;
  const auto add_all = [&out](const weir_module* module) {
    for (auto* table = module->converters; table && *table; ++table) out.push_back(*table);
  };
  std::vector<const weir_module*> builtins;
  {
    std::lock_guard lock(mutex_);
    builtins = builtins_;
  }
  for (const auto* module : builtins) add_all(module);
  const auto built_in = [&out](const std::string& name) {
    return std::any_of(out.begin(), out.end(), [&](const auto* t) { return t->name == name; });
  };
  for (const auto& name : converter_names()) {
    if (built_in(name)) continue;
    const auto module = open("converter", name);
    if (!module)
      host().log(WEIR_LOG_WARNING, file_name("converter", name).c_str(),
                 module.error().message().c_str());
    else if (*module)
      add_all(*module);
  }
  return out;
}

std::vector<std::string> list_accelerators(const weir_engine& engine) {
  std::vector<std::string> out;
  const auto extension = get_function(engine, &weir_engine::extension);
  if (!extension) return out;
  const auto* list = static_cast<const char*>(extension("weir.accelerators/1"));
  for (const auto name : split(list ? list : "", ","))
    if (const auto word = strip(name); !word.empty()) out.emplace_back(word);
  return out;
}

}  // namespace weir::infer
