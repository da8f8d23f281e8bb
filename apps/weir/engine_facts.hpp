// What is known of each engine on this machine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "weir/abi.h"

namespace weir::app {

enum class EngineState {
  Usable,
  Refused,       // a module file is there and cannot be used: `problem` says why
  NotInstalled,  // `install` brings it
  NotAvailable,  // this version of Weir has no module for it
};

struct EngineFact {
  std::string name;
  std::string aliases, extensions;  // comma lists
  EngineState state = EngineState::NotAvailable;
  std::string version;
  std::string file;     // of the module, "" when there is none
  std::string library;  // of the engine itself, where it could be found in this process
  std::string problem;
  std::string install;
};

const char* name_of(EngineState state) noexcept;
// The engines that Weir knows, then those it found beside them. Opens every module.
std::vector<EngineFact> engine_facts();
// Of the engine's library where the module tells it, else of the module.
std::string engine_version(const weir_engine& engine);
// The module file that would be opened for an engine (or a decoder, a converter) of this name, ""
// when there is none.
std::string module_file(const std::string& name, const std::string& kind = "engine");

}  // namespace weir::app
