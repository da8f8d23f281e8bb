// A frame that ended a worker process, kept in a file that a pipeline can read again.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::isolate {

struct CrashFile {
  std::string path;
  uint64_t bytes = 0;
  // Runs the frame again through `element`, which is tensor_filter with its properties.
  std::string line(const std::string& element) const;
};

// The frame's tensors one behind the other, each with the header of flexible streams in front, as a
// new file in `folder` that nobody else may read. FILE_NOT_WRITTEN.
Result<CrashFile> save_frame(const std::string& folder, const weir_frame& frame);

}  // namespace weir::isolate
