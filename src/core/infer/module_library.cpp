// dlopen with plain words.
#include "core/infer/module_library.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>

#include "core/infer/host.hpp"
#include "core/infer/known_engines.hpp"
#include "core/infer/module_check.hpp"
#include "core/text/text.hpp"

namespace weir::infer {
namespace {

namespace fs = std::filesystem;

std::string file_name(const std::string& kind, const std::string& name) {
  return "libweir-" + kind + "-" + name + ".so";
}

std::string list(const std::vector<std::string>& words) {
  std::string out;
  for (const auto& word : words) out += (out.empty() ? "" : ", ") + word;
  return out.empty() ? "none" : out;
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

std::string extension_of(const std::string& path) {
  const size_t dot = path.rfind('.');
  return dot == std::string::npos ? "" : lower(path.substr(dot + 1));
}

}  // namespace

ModuleLibrary& ModuleLibrary::instance() {
  static ModuleLibrary library;
  return library;
}

std::vector<std::string> ModuleLibrary::search_path() {
  std::vector<std::string> out;
  if (const char* text = std::getenv("WEIR_MODULE_PATH"))
    for (const auto part : split(text, ":"))
      if (!part.empty()) out.emplace_back(part);
  out.emplace_back(WEIR_MODULE_DIR);
  return out;
}

void ModuleLibrary::add_builtin(const weir_module* module) {
  std::lock_guard lock(mutex_);
  builtins_.push_back(module);
}

// A null module without an error: there is no such file.
Result<const weir_module*> ModuleLibrary::open(const std::string& kind, const std::string& name) {
  for (const auto& folder : search_path()) {
    const std::string path = (fs::path(folder) / file_name(kind, name)).string();
    std::error_code ignored;
    if (!fs::is_regular_file(path, ignored)) continue;
    std::lock_guard lock(mutex_);
    const auto known = opened_.find(path);
    if (known != opened_.end()) return known->second;
    void* handle = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!handle) {
      const char* reason = dlerror();
      return module_refused(path, reason ? reason : "dlopen failed",
                            "a shared object for this machine");
    }
    using Entry = const weir_module* (*)(const weir_host*);
    const auto entry = reinterpret_cast<Entry>(dlsym(handle, "weir_module_entry"));
    if (!entry) return module_refused(path, "no symbol weir_module_entry", "that symbol, exported");
    const weir_module* module = entry(&host());
    if (auto status = check_module(module, path); !status) return status.error();
    opened_.emplace(path, module);
    return module;
  }
  return nullptr;
}

std::vector<std::string> ModuleLibrary::names(const std::string& kind) const {
  std::set<std::string> out;
  const std::string prefix = "libweir-" + kind + "-";
  for (const auto& folder : search_path()) {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
      const std::string file = entry.path().filename().string();
      if (file.starts_with(prefix) && file.ends_with(".so"))
        out.insert(file.substr(prefix.size(), file.size() - prefix.size() - 3));
    }
  }
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

Result<const weir_engine*> ModuleLibrary::engine(std::string_view word) {
  {
    std::lock_guard lock(mutex_);
    for (const auto* module : builtins_)
      if (const auto* table = find_in(module->engines, word)) return table;
  }
  const KnownEngine* known = known_engine(word);
  const std::string name(known ? known->name : word);
  const bool plain = name.find('/') == std::string::npos && !name.empty();
  auto module = plain ? open("engine", name) : Result<const weir_module*>(nullptr);
  if (!module) return module.error();
  if (*module) {
    if (const auto* table = find_in((*module)->engines, word)) return table;
    if ((*module)->engines && (*module)->engines[0]) return (*module)->engines[0];
    return module_refused(file_name("engine", name), "no engine in it", "one");
  }
  if (known)
    return Error{Code::ENGINE_NOT_INSTALLED,
                 "the engine " + name + " is not installed",
                 "framework=" + std::string(word),
                 "one of: " + list(engine_names()),
                 "",
                 known->install.empty() ? "this version of Weir has no module for " + name
                                        : std::string(known->install) + " && make build"};
  std::vector<std::string> candidates = engine_names();
  for (const auto& engine : known_engines()) {
    candidates.emplace_back(engine.name);
    for (const auto alias : split(engine.aliases, ",")) candidates.emplace_back(alias);
  }
  const std::string close = nearest(word, candidates);
  return Error{Code::ENGINE_UNKNOWN,
               "no engine has this name",
               "framework=" + std::string(word),
               "one of: " + list(engine_names()),
               close.empty() ? "" : "did you mean " + close + "?",
               close.empty() ? "framework=auto" : "framework=" + close};
}

Result<const weir_engine*> ModuleLibrary::engine_for_model(std::span<const std::string> paths) {
  std::error_code ignored;
  if (!paths.empty() && fs::is_directory(paths[0], ignored)) return engine("nnfw");
  const auto unknown = [&](const std::string& model) {
    return Error{Code::ENGINE_UNKNOWN,
                 "no engine claims this model file by its name",
                 model,
                 "a file ending in .onnx, .tflite, ...",
                 "",
                 "name the engine: framework=onnxruntime"};
  };
  if (paths.size() == 2) {
    const std::set<std::string> both{extension_of(paths[0]), extension_of(paths[1])};
    if (both == std::set<std::string>{"so", "nb"}) return engine("vivante");
    if (both == std::set<std::string>{"caffemodel", "prototxt"}) return engine("caffe");
  }
  if (paths.size() != 1) return unknown(paths.empty() ? "no model" : paths[0] + " and others");
  const KnownEngine* known = known_engine_for(extension_of(paths[0]));
  if (known) return engine(known->name);
  return unknown(paths[0]);
}

Result<const weir_decoder_type*> ModuleLibrary::decoder(std::string_view name) {
  {
    std::lock_guard lock(mutex_);
    for (const auto* module : builtins_)
      if (const auto* table = find_in(module->decoders, name)) return table;
  }
  const bool plain = !name.empty() && name.find('/') == std::string_view::npos;
  auto module = plain ? open("decoder", std::string(name)) : Result<const weir_module*>(nullptr);
  if (!module) return module.error();
  if (*module)
    if (const auto* table = find_in((*module)->decoders, name)) return table;
  const auto available = decoder_names();
  const std::string close = nearest(name, available);
  return Error{Code::DECODER_UNKNOWN,
               "no decoder has this name",
               "mode=" + std::string(name),
               "one of: " + list(available),
               close.empty() ? "" : "did you mean " + close + "?",
               close.empty() ? "gst-inspect-1.0 tensor_decoder" : "mode=" + close};
}

Result<const weir_converter_type*> ModuleLibrary::converter(std::string_view name) {
  {
    std::lock_guard lock(mutex_);
    for (const auto* module : builtins_)
      if (const auto* table = find_in(module->converters, name)) return table;
  }
  const bool plain = !name.empty() && name.find('/') == std::string_view::npos;
  auto module = plain ? open("converter", std::string(name)) : Result<const weir_module*>(nullptr);
  if (!module) return module.error();
  if (*module)
    if (const auto* table = find_in((*module)->converters, name)) return table;
  return Error{Code::CONVERTER_UNKNOWN,
               "no converter has this name",
               std::string(name),
               "one of: " + list(converter_names()),
               "",
               "gst-inspect-1.0 tensor_converter"};
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

}  // namespace weir::infer
