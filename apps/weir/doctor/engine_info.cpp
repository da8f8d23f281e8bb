// Opens every engine module once, after a trial in a forked process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "doctor/engine_info.hpp"

#include <filesystem>

#include "core/infer/module/known_engines.hpp"
#include "core/infer/module/module_library.hpp"
#include "doctor/forked_load.hpp"

namespace weir::app {
namespace {

namespace fs = std::filesystem;

// Path and version of the engine's library ("weir.library/1"); null when the module does not report
// them or the library is unusable.
const char* const* get_library(const weir_engine& engine) {
  if (!engine.extension) return nullptr;
  return static_cast<const char* const*>(engine.extension("weir.library/1"));
}

// The library's problem and the command that fixes it ("weir.library-problem/1"); null without a
// problem.
const char* const* get_library_problem(const weir_engine& engine) {
  if (!engine.extension) return nullptr;
  return static_cast<const char* const*>(engine.extension("weir.library-problem/1"));
}

void describe(const weir_engine& engine, EngineInfo* fact) {
  fact->version = engine_version(engine);
  const auto* library = get_library(engine);
  if (library) fact->library = library[0];
  const auto* problem = library ? nullptr : get_library_problem(engine);
  fact->state = problem ? EngineState::NotInstalled : EngineState::Usable;
  if (!problem) return;
  fact->problem = problem[0];
  fact->install = problem[1];
}

void describe_missing(const Error& error, EngineInfo* fact) {
  if (fact->file.empty()) {
    fact->state = fact->install.empty() ? EngineState::NotAvailable : EngineState::NotInstalled;
    return;
  }
  fact->state = EngineState::Refused;
  fact->problem = error.what + (error.offered.empty() ? "" : ": " + error.offered);
  if (fact->install.empty()) fact->install = error.fix;
}

void look_at(EngineInfo* fact) {
  fact->file = module_file(fact->name);
  if (!fact->file.empty())
    fact->problem = failure_of_load(
        [&] { static_cast<void>(infer::ModuleLibrary::instance().engine(fact->name)); });
  if (!fact->problem.empty()) {
    fact->state = EngineState::Refused;
    fact->problem = "the module cannot be loaded: " + fact->problem;
    return;
  }
  const auto engine = infer::ModuleLibrary::instance().engine(fact->name);
  if (engine)
    describe(**engine, fact);
  else
    describe_missing(engine.error(), fact);
}

}  // namespace

const char* to_string(EngineState state) noexcept {
  switch (state) {
    case EngineState::Usable:
      return "usable";
    case EngineState::Refused:
      return "refused";
    case EngineState::NotInstalled:
      return "not installed";
    case EngineState::NotAvailable:
      return "not available";
  }
  return "";
}

std::string engine_version(const weir_engine& engine) {
  if (const auto* library = get_library(engine)) return library[1];
  return engine.version ? engine.version : "";
}

std::string module_file(const std::string& name, const std::string& kind) {
  const std::string file = "libweir-" + kind + "-" + name + ".so";
  for (const auto& folder : infer::ModuleLibrary::search_path()) {
    std::error_code ignored;
    const fs::path path = fs::path(folder) / file;
    if (fs::is_regular_file(path, ignored)) return path.string();
  }
  return "";
}

std::vector<EngineInfo> list_engines() {
  std::vector<EngineInfo> out;
  for (const auto& known : infer::known_engines()) {
    EngineInfo fact;
    fact.name = known.name;
    fact.aliases = known.aliases;
    fact.extensions = known.extensions;
    fact.install = known.install;
    out.push_back(std::move(fact));
  }
  for (const auto& name : infer::ModuleLibrary::instance().engine_names()) {
    if (infer::known_engine(name)) continue;
    EngineInfo fact;
    fact.name = name;
    out.push_back(std::move(fact));
  }
  for (auto& fact : out) look_at(&fact);
  return out;
}

}  // namespace weir::app
