// Engines for filter descriptors. All share one implementation, so each is passed its own name.
// Loading the library registers them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <dlfcn.h>

#include <deque>
#include <filesystem>
#include <mutex>

#include "compat/filter_model.hpp"
#include "compat/framework_check.hpp"
#include "compat/guard.hpp"
#include "core/custom/foreign_class.hpp"
#include "core/infer/module/host.hpp"
#include "core/process/process_object.hpp"
#include "core/subplugin/loader.hpp"
#include "core/subplugin/table.hpp"
#include "library/process.h"

namespace weir::compat {
namespace {

std::shared_ptr<OpenFilter> open_framework(const OpenRequest& request) {
  const std::string name(request.options.get("framework").value_or(""));
  const auto* framework = static_cast<const GstTensorFilterFramework*>(
      subplugin::table().find(subplugin::Kind::Filter, name));
  if (!framework)
    throw Failure({.code = Code::ENGINE_UNKNOWN,
                   .what = "the sub-plugin is no longer registered",
                   .offered = "framework=" + name,
                   .needed = "a sub-plugin that nnstreamer_filter_probe() registered"});
  auto properties = std::make_unique<Properties>(name, name, request);
  const auto facts = value_or_throw(read_facts(*framework));
  return facts.version == 0 ? open_v0(*framework, std::move(properties))
                            : open_v1(*framework, std::move(properties));
}

Failure not_loaded(const std::string& file, const std::string& offered, const std::string& needed,
                   const std::string& fix) {
  return Failure({.code = Code::MODULE_REFUSED,
                  .what = "the custom filter " + file + " cannot be loaded",
                  .offered = offered,
                  .needed = needed,
                  .fix = fix});
}

std::string reason_of_loader() {
  const char* reason = dlerror();
  return reason ? reason : "dlopen failed";
}

std::shared_ptr<OpenFilter> open_file(const OpenRequest& request) {
  if (request.paths.size() != 1)
    throw Failure({.code = Code::OPTION_VALUE,
                   .what = "a custom filter must be a single file",
                   .offered = std::to_string(request.paths.size()) + " paths in model=",
                   .needed = "model=lib.so",
                   .fix = "framework=custom model=/path/to/lib.so"});
  const std::string file = request.paths[0];
  const std::string path = std::filesystem::absolute(file).string();
  // Never closed: its memory may still be in use.
  void* handle = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle)
    throw not_loaded(file, reason_of_loader(),
                     "a shared object for this machine without undefined symbols",
                     "ldd -r " + path);
  const auto* symbol =
      static_cast<NNStreamer_custom_class* const*>(dlsym(handle, "NNStreamer_custom"));
  if (!symbol || !*symbol)
    throw not_loaded(file, symbol ? "NNStreamer_custom is NULL" : "no symbol NNStreamer_custom",
                     "the exported pointer to the callbacks of the filter",
                     "NNStreamer_custom_class *NNStreamer_custom = &callbacks;");
  return open_class(**symbol, std::make_unique<Properties>("custom", file, request));
}

struct Engine {
  const void* descriptor;
  std::string name;
  weir_engine table;
};
struct Engines {
  std::mutex mutex;  // guards all
  std::deque<Engine> all;
};
Engines& engines() {
  static auto& all = *new Engines;  // never freed: elements may outlive static objects
  return all;
}

// Returns the engine of a registered descriptor (const GstTensorFilterFramework*); valid until the
// process ends. Null, with a log line, when it cannot be used.
const weir_engine* find_engine(const void* descriptor) {
  return or_else<const weir_engine*>(__func__, nullptr, [&]() -> const weir_engine* {
    accept_host(&infer::host());
    const auto facts = read_facts(*static_cast<const GstTensorFilterFramework*>(descriptor));
    if (!facts) {
      warn("nnstreamer_filter_probe", facts.error());
      return nullptr;
    }
    std::lock_guard lock(engines().mutex);
    for (const auto& engine : engines().all)
      if (engine.descriptor == descriptor && engine.name == facts->name) return &engine.table;
    auto& engine = engines().all.emplace_back(Engine{descriptor, facts->name, {}});
    engine.table = engine_table<Opened<open_framework>>(engine.name.c_str(), "1", "", "");
    engine.table.flags = (facts->runs_without_model ? uint64_t{WEIR_ENGINE_NEEDS_NO_MODEL} : 0) |
                         (facts->verifies_paths ? 0 : uint64_t{WEIR_ENGINE_MODEL_IS_NO_FILE});
    return &engine.table;
  });
}

// Returns the engine for a shared object that exports NNStreamer_custom, which is its only model
// file.
const weir_engine& class_engine() {
  static const weir_engine table = [] {
    accept_host(&infer::host());
    return engine_table<Opened<open_file>>("custom", "1", "", "");
  }();
  return table;
}

// Makes libnnstreamer-single.so available from this library's folder to files that link with it,
// whatever the loader's search path is.
void open_the_other_name() {
  Dl_info own{};
  if (!dladdr(reinterpret_cast<void*>(open_the_other_name), &own) || !own.dli_fname) return;
  const auto folder = std::filesystem::path(own.dli_fname).parent_path();
  dlopen((folder / "libnnstreamer-single.so").c_str(), RTLD_LAZY | RTLD_LOCAL);
}

// Runs before the constructors of sub-plugins, which link with this library: process-wide objects
// are those of libweir.
__attribute__((constructor)) static void take_the_process() {
  process::take_objects_from(weir_process_object);
  subplugin::set_engine_adapter(find_engine);
  subplugin::set_hardware_check(has_hardware);
  custom::set_class_engine(class_engine);
  attempt("libnnstreamer.so", open_the_other_name);
}

}  // namespace
}  // namespace weir::compat
