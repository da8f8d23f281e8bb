// ModuleLibrary: finds engines, decoders and converters in module files, opened on demand.
#pragma once
#include <map>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/infer/engine_choice.hpp"
#include "core/infer/module_tables.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::infer {

// Process-wide and thread-safe. Files libweir-{engine,decoder,converter}-NAME.so are looked for in
// the folders of WEIR_MODULE_PATH or [module] path (colon lists), then in the folder chosen when
// Weir was built. A module stays open until the process ends.
class ModuleLibrary {
 public:
  static ModuleLibrary& instance();
  ModuleLibrary() = default;  // a separate one, for tests

  // By name or alias, then a filter for NNStreamer of this name, then what nnstreamer.ini says that
  // the name means: ENGINE_UNKNOWN with the list, ENGINE_NOT_INSTALLED with the command that
  // brings it, MODULE_REFUSED when the file is there and cannot be used.
  Result<const weir_engine*> engine(std::string_view name);
  // By the model's files (specification 4.2).
  Result<const weir_engine*> engine_for_model(std::span<const std::string> paths);
  // The name of that engine, which may not be installed, and why; no module is opened.
  Result<EngineChoice> choose_engine(std::span<const std::string> paths) const;
  Result<const weir_decoder_type*> decoder(std::string_view name);
  // CONVERTER_UNKNOWN with the list, MODULE_REFUSED when the file is there and cannot be used.
  Result<const weir_converter_type*> converter(std::string_view name);
  // Every converter, each module opened; those that cannot be used are left out, with a line in
  // the log.
  std::vector<const weir_converter_type*> converters();

  // Names for which there is a file or a built-in, sorted; nothing is opened.
  // Engines: those of sub-plugins for NNStreamer too.
  std::vector<std::string> engine_names() const;
  std::vector<std::string> decoder_names() const { return names("decoder"); }
  std::vector<std::string> converter_names() const { return names("converter"); }
  // The folders in the order they are searched.
  static std::vector<std::string> search_path();

  // Adds tables of the process itself; `module` must outlive the library.
  void add_builtin(const weir_module* module);

 private:
  Result<const weir_engine*> named_engine(std::string_view name);
  Result<const weir_module*> open(const std::string& kind, const std::string& name);
  std::vector<std::string> names(const std::string& kind) const;

  mutable std::mutex mutex_;  // guards the rest; never held while a module is called
  std::map<std::string, std::unique_ptr<ModuleTables>> opened_;  // by path
  std::vector<const weir_module*> builtins_;
};

// What the engine says that it runs on ("weir.accelerators/1": a comma list of names of
// specification 4.4, its automatic choice first); empty when it does not say.
std::vector<std::string> accelerators_of(const weir_engine& engine);

}  // namespace weir::infer
