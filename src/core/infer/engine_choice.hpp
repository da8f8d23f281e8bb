// Which engine runs a model that names none, and why.
#pragma once
#include <span>
#include <string>
#include <vector>

#include "core/config/configuration.hpp"
#include "core/config/nnstreamer.hpp"
#include "weir/result.hpp"

namespace weir::infer {

struct EngineChoice {
  std::string engine;               // may not be installed
  std::string reason;               // "the file's name ends in .tflite; ..."
  std::vector<std::string> others;  // installed ones that take such files too

  std::string words() const;  // all three in one line
};

// By the names of the model's files (specification 4.2): the first engine that is installed of the
// list [filter] priority_EXTENSION, then of nnstreamer.ini's framework_priority_EXTENSION (null:
// there is none), then of Weir's own list, then the one that Weir knows for such files. `installed`
// is sorted. ENGINE_UNKNOWN when nobody claims them.
Result<EngineChoice> choose_engine(std::span<const std::string> paths,
                                   std::span<const std::string> installed,
                                   const config::Configuration& configuration,
                                   const config::NnstreamerConfiguration* nnstreamer = nullptr);

}  // namespace weir::infer
