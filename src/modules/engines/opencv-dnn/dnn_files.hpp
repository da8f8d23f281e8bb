// Finds the files of a network: the role of each given file, and where a missing one is.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "opencv-dnn/dnn_model.hpp"

namespace weir::engine {

struct DnnSource {
  DnnFiles files;
  DnnDescription description;
};

// One file is enough if the other has the same path with its own extension. Checks everything that
// can be checked before OpenCV reads the files.
Result<DnnSource> read_dnn_files(const weir_open& request);

}  // namespace weir::engine
