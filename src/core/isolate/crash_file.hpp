// Saves the frame that crashed a worker process in a file that a pipeline can replay.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::isolate {

struct CrashFile {
  std::string path;
  uint64_t bytes = 0;
  // The command that runs the frame again through `element`, tensor_filter with its properties.
  std::string line(const std::string& element) const;
};

// Writes the frame's tensors one after another, each preceded by the header of flexible streams, to
// a new file in `folder` that only the user can read. FILE_NOT_WRITTEN.
Result<CrashFile> save_frame(const std::string& folder, const weir_frame& frame);

}  // namespace weir::isolate
