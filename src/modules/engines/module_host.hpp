// The parts of weir/module.hpp that engines use, and their log.
#pragma once
#include <string>

#include "weir/module.hpp"

namespace weir::engine {

using weir::fail;
using weir::guarded;
using weir::module_host;
inline const char* module_name = "engine";  // set by module_of

inline void log(weir_log_level level, const std::string& text) {
  if (module_host && module_host->log) module_host->log(level, module_name, text.c_str());
}

}  // namespace weir::engine
