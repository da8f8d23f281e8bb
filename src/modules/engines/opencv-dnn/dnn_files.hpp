// The files of a network: which of those given is which, and where the other lies.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "opencv-dnn/dnn_model.hpp"

namespace weir::engine {

struct DnnSource {
  DnnFiles files;
  DnnDescription description;
};

// One file names the other where that lies beside it and differs in its ending only. Everything is
// checked that can be checked before OpenCV reads it.
Result<DnnSource> read_dnn_files(const weir_open& request);

}  // namespace weir::engine
