// EngineOption: an option that an engine declares.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "report.hpp"
#include "weir/abi.h"

namespace weir::app {

struct EngineOption {
  std::string name, type, by_default, help;
};

// From the engine's options_json. Empty when it is missing or invalid.
std::vector<EngineOption> engine_options(const weir_engine& engine);
// The same from such a text, also of a decoder or converter; may be null.
std::vector<EngineOption> engine_options(const char* options_json);
Json to_json(const std::vector<EngineOption>& options);
// "name:value,name:value", the syntax of custom=.
std::vector<std::pair<std::string, std::string>> custom_options(const std::string& text);
void print_options(const std::vector<EngineOption>& options);

}  // namespace weir::app
