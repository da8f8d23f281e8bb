// The options of the ONNX Runtime engine.
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
  int threads = 1;     // within one operator
  bool spins = false;  // its threads wait for the next operator without sleeping
  GraphOptimizationLevel optimization = ORT_ENABLE_ALL;
  bool lowering_cache = true;  // of TensorFlow Lite models that are lowered
  // Keys of onnxruntime_session_options_config_keys.h, set as they are.
  std::map<std::string, std::string> config;

  // NumThreads:N, GraphOptimization:{none,basic,extended,all}, Spinning:{true,false},
  // LoweringCache:{true,false}, and every key with a dot in it as ONNX Runtime has it. Unknown keys
  // are logged; a value that cannot be used is OPTION_VALUE.
  //
  // Where nobody says how many threads (weir_open::threads is 0: the model is the only one of the
  // process, and runs one frame at a time) it gets all cores, and its threads spin for up to
  // kSpinMicroseconds: long enough from one operator to the next, short enough to leave the cores
  // to others between two frames. `version` is the library's.
  static Result<OrtOptions> read(const weir_open& request, const std::string& version);
};

}  // namespace weir::engine
