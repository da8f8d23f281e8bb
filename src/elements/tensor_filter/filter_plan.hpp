// FilterPlan: what tensor_filter does with each frame of the present caps. Immutable once made.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <vector>

#include "core/filter/combination.hpp"
#include "core/filter/model_shape.hpp"
#include "core/infer/batch_group.hpp"
#include "core/infer/row_runner.hpp"
#include "core/limit/buffer_limit.hpp"

namespace weir {

struct FilterPlan {
  FrameSpec input;                           // of the sink pad
  FrameSpec output;                          // of the source pad
  std::vector<size_t> input_choice;          // stream tensors given to the model; empty = all
  OutputCombination output_choice;           // empty = all model outputs
  std::vector<ModelShape> declared_inputs;   // as the model and the user say, parts may be open
  std::vector<ModelShape> model_inputs;      // exact shapes, fixed when input is static
  std::vector<ModelShape> model_outputs;     // exact shapes; parts may be open
  bool outputs_fixed = false;                // every output size is known before the invoke
  bool engine_allocates = false;             // though it may be: the engine says it anew
  bool dynamic = false;                      // invoke-dynamic: headers say that they are flexible
  size_t alignment = 1;                      // bytes, of each of the model's inputs
  size_t padding = 0;                        // readable bytes behind each
  std::shared_ptr<infer::BatchGroup> batch;  // null: each frame is an invoke of its own
  infer::RowLimits rows;                     // of one invoke
  const BufferLimit* limit = nullptr;        // of each output; borrowed from the element

  // The engine writes into memory of a pool.
  bool has_memory() const noexcept { return outputs_fixed && !engine_allocates; }
  // Of each tensor of a flexible stream.
  Format header_format() const noexcept { return dynamic ? Format::Flexible : Format::Static; }
};

}  // namespace weir
