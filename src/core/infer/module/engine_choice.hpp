// Chooses the engine for a model without framework=, and explains the choice.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string>
#include <vector>

#include "core/config/configuration.hpp"
#include "core/config/nnstreamer.hpp"
#include "weir/result.hpp"

namespace weir::infer {

struct EngineChoice {
  std::string engine;               // not necessarily installed
  std::string reason;               // "the file has the extension .tflite; ..."
  std::vector<std::string> others;  // other installed engines for such files

  std::string to_string() const;  // all three on one line
};

// Chooses by the file names of the model (docs/compatibility/filter.md 4.2): the first installed
// engine of the list [filter] priority_EXTENSION, of nnstreamer.ini's framework_priority_EXTENSION
// (null: no such file), of Weir's own list, then the engine that Weir knows for such files.
// `installed` is sorted. ENGINE_UNKNOWN if no engine matches.
Result<EngineChoice> choose_engine(std::span<const std::string> paths,
                                   std::span<const std::string> installed,
                                   const config::Configuration& configuration,
                                   const config::NnstreamerConfiguration* nnstreamer = nullptr);

}  // namespace weir::infer
