// The options of the ONNX Runtime engine.
#pragma once
#include <onnxruntime_c_api.h>

#include <string>
#include <utility>
#include <vector>

#include "onnxruntime/ort_arena.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::engine {

struct OrtOptions {
  int threads = 1;  // within one operator
  GraphOptimizationLevel optimization = ORT_ENABLE_ALL;
  bool lowering_cache = true;  // of TensorFlow Lite models that are lowered
  // Keys of onnxruntime_session_options_config_keys.h, set as they are; later ones win.
  std::vector<std::pair<std::string, std::string>> config{{"session.intra_op.allow_spinning", "0"},
                                                          {"session.inter_op.allow_spinning", "0"},
                                                          {kSharedArenaKey, "1"},
                                                          {kWeightsApartKey, "1"}};

  // NumThreads:N, GraphOptimization:{none,basic,extended,all}, Spinning:{true,false},
  // LoweringCache:{true,false}, and every key with a dot in it as ONNX Runtime has it. Unknown keys
  // are logged; a value that cannot be used is OPTION_VALUE.
  static Result<OrtOptions> read(const weir_open& request);
};

}  // namespace weir::engine
