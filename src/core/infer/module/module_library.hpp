// ModuleLibrary: finds engines, decoders and converters in module files and opens them on demand.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/infer/module/engine_choice.hpp"
#include "core/infer/module/module_tables.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::infer {

// Engines from outside module files and registered tables. Thread-safe.
struct EngineSource {
  // Returns null without an error if the source has no engine of this name.
  Result<const weir_engine*> (*engine)(std::string_view name);
  // Names that engine() may find; opens nothing.
  std::vector<std::string> (*names)();
};

// Process-wide and thread-safe. Searches for libweir-{engine,decoder,converter}-NAME.so in the
// folders of WEIR_MODULE_PATH or [module] path (colon-separated), then in the folder chosen when
// Weir was built. A module stays open until the process ends.
class ModuleLibrary {
 public:
  // The library of the process, with all of Weir's engine sources (core/engines).
  static ModuleLibrary& instance();
  ModuleLibrary() = default;  // a separate library, for tests

  // Finds an engine by name or alias, then a filter for NNStreamer of this name, then the name that
  // nnstreamer.ini maps it to. ENGINE_UNKNOWN with the list, ENGINE_NOT_INSTALLED with the install
  // command, MODULE_REFUSED if the file exists but is unusable.
  Result<const weir_engine*> engine(std::string_view name);
  // Chooses an engine by the model's files (docs/compatibility/filter.md 4.2).
  Result<const weir_engine*> engine_for_model(std::span<const std::string> paths);
  // The name of that engine, which may not be installed, and the reason; opens no module.
  Result<EngineChoice> choose_engine(std::span<const std::string> paths) const;
  Result<const weir_decoder_type*> decoder(std::string_view name);
  // CONVERTER_UNKNOWN with the list, MODULE_REFUSED if the file exists but is unusable.
  Result<const weir_converter_type*> converter(std::string_view name);
  // Opens every module and returns all converters; logs and skips unusable ones.
  std::vector<const weir_converter_type*> converters();

  // Names of existing files and built-in tables, sorted; opens nothing. engine_names() includes
  // sub-plugins for NNStreamer.
  std::vector<std::string> engine_names() const;
  std::vector<std::string> decoder_names() const { return names("decoder"); }
  std::vector<std::string> converter_names() const { return names("converter"); }
  // The folders in search order.
  static std::vector<std::string> search_path();

  // Adds tables of the application; `module` must outlive the library.
  void add_builtin(const weir_module* module);
  // Adds a source that is queried after the built-in tables and the module files.
  void add_source(EngineSource source);

 private:
  Result<const weir_engine*> named_engine(std::string_view name);
  Result<const weir_module*> open(const std::string& kind, const std::string& name);
  std::vector<std::string> names(const std::string& kind) const;
  std::vector<EngineSource> sources() const;

  mutable std::mutex mutex_;  // guards the rest; never held during calls into a module
  std::map<std::string, std::unique_ptr<ModuleTables>> opened_;  // by path
  std::vector<const weir_module*> builtins_;
  std::vector<EngineSource> sources_;
};

// The accelerators that the engine supports ("weir.accelerators/1": a comma-separated list of names
// of docs/compatibility/filter.md 4.4, its automatic choice first); empty if it does not report
// them.
std::vector<std::string> list_accelerators(const weir_engine& engine);

}  // namespace weir::infer
