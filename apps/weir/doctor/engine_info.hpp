// EngineInfo: the state of an engine on this machine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "weir/abi.h"

namespace weir::app {

enum class EngineState {
  Usable,
  Refused,       // the module file exists but is unusable: see `problem`
  NotInstalled,  // `install` installs it
  NotAvailable,  // this version of Weir has no module for it
};

struct EngineInfo {
  std::string name;
  std::string aliases, extensions;  // comma lists
  EngineState state = EngineState::NotAvailable;
  std::string version;
  std::string file;     // module file, "" when there is none
  std::string library;  // path of the engine's own library, if this process found it
  std::string problem;
  std::string install;
};

const char* to_string(EngineState state) noexcept;
// The engines that Weir knows, followed by others found. Opens every module.
std::vector<EngineInfo> list_engines();
// The version of the engine's library if the module reports it, otherwise the module's.
std::string engine_version(const weir_engine& engine);
// The module file that would be loaded for this engine, decoder or converter; "" when there is
// none.
std::string module_file(const std::string& name, const std::string& kind = "engine");

}  // namespace weir::app
