// FilterPlan: how tensor_filter processes frames with the current caps. Immutable.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <vector>

#include "core/filter/combination.hpp"
#include "core/filter/model_fit.hpp"
#include "core/infer/batch/batch_group.hpp"
#include "core/infer/batch/row_runner.hpp"
#include "core/limit/buffer_limit.hpp"

namespace weir {

struct FilterPlan {
  FrameSpec input;                   // of the sink pad
  FrameSpec output;                  // of the source pad
  std::vector<size_t> input_choice;  // stream tensors given to the model; empty = all
  OutputCombination output_choice;   // empty = all model outputs
  std::vector<ModelTensor>
      declared_inputs;  // from the model and the properties; may be partly unknown
  std::vector<ModelTensor> model_inputs;   // exact shapes, fixed when input is static
  std::vector<ModelTensor> model_outputs;  // exact shapes; may be partly unknown
  bool outputs_fixed = false;              // every output size is known before the invoke
  bool engine_allocates = false;  // even if outputs_fixed: the engine decides for each frame
  bool dynamic = false;           // invoke-dynamic: headers have format flexible
  size_t alignment = 1;           // bytes, of each of the model's inputs
  size_t padding = 0;             // readable bytes after each
  size_t fallback_alignment = 1, fallback_padding = 0;  // what the fallback needs as well
  std::shared_ptr<infer::BatchGroup> batch;             // null: one invoke for each frame
  infer::RowLimits rows;                                // of one invoke
  const BufferLimit* limit = nullptr;                   // of each output; borrowed from the element

  // Whether the engine writes into pooled memory.
  bool has_memory() const noexcept { return outputs_fixed && !engine_allocates; }
  // The format in the header of each tensor of a flexible stream.
  Format header_format() const noexcept { return dynamic ? Format::Flexible : Format::Static; }
};

}  // namespace weir
