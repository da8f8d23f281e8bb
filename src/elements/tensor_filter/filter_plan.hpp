// FilterPlan: what tensor_filter does with each frame of the present caps. Immutable once made.
#pragma once
#include <vector>

#include "core/filter/combination.hpp"
#include "core/filter/model_shape.hpp"

namespace weir {

struct FilterPlan {
  FrameSpec input;                          // of the sink pad
  FrameSpec output;                         // of the source pad
  std::vector<size_t> input_choice;         // stream tensors given to the model; empty = all
  OutputCombination output_choice;          // empty = all model outputs
  std::vector<ModelShape> declared_inputs;  // as the model and the user say, parts may be open
  std::vector<ModelShape> model_inputs;     // exact shapes, fixed when input is static
  std::vector<ModelShape> model_outputs;    // exact shapes; parts may be open
  bool outputs_fixed = false;               // every output size is known before the invoke
  size_t alignment = 1;                     // bytes, of each of the model's inputs
  size_t padding = 0;                       // readable bytes behind each
};

}  // namespace weir
