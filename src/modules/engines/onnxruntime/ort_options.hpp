// OrtOptions: the options of the ONNX Runtime engine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <onnxruntime_c_api.h>

#include <map>
#include <string>

#include "onnxruntime/ort_arena.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::engine {

struct OrtOptions {
  int threads = 1;       // per operator
  bool by_size = false;  // neither the user nor the host said how many: one for a small model
  bool spins = false;    // threads spin while they wait for the next operator
  GraphOptimizationLevel optimization = ORT_ENABLE_ALL;
  // Keys of onnxruntime_session_options_config_keys.h, passed on unchanged.
  std::map<std::string, std::string> config;

  // NumThreads:N, GraphOptimization:{none,basic,extended,all}, Spinning:{true,false}, and
  // every ONNX Runtime key that contains a dot. Unknown keys are logged; OPTION_VALUE for an
  // invalid value.
  //
  // If no thread count is set (weir_open::threads is 0: the only model of the process, one frame at
  // a time), the model gets all cores, or one thread if it is small. Its threads then spin for up
  // to kSpinMicroseconds: enough to bridge two operators, and short enough to free the cores
  // between two frames. `version` is the library's.
  static Result<OrtOptions> read(const weir_open& request, const std::string& version);
};

}  // namespace weir::engine
