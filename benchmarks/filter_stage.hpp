// Pipeline: a model in a pipeline, for benchmarks of tensor_filter.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "bare_loop.hpp"
#include "stream_stage.hpp"

namespace weir::bench {

// appsrc ! ELEMENTS ! fakesink, for the input of a bare loop.
class Pipeline : public Stage {
 public:
  // A tensor_filter with additional `properties`. `ahead`: frames queued in advance.
  Pipeline(const BareLoop& bare, const std::string& model, int threads,
           const std::string& properties = "", int ahead = 64)
      : Stage(bare.caps(), bare.input_bytes(),
              "tensor_filter model=" + model + " custom=NumThreads:" + std::to_string(threads) +
                  " " + properties,
              ahead) {}
  Pipeline(const BareLoop& bare, const std::string& between)
      : Stage(bare.caps(), bare.input_bytes(), between) {}
};

}  // namespace weir::bench
