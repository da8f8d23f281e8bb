// Inputs: what a program hands to a model, held against what the model takes, and where the engine
// wants it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string>
#include <vector>

#include "core/direct/results.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::direct {

// What memory must be like (weir_model_info).
struct MemoryNeeds {
  uint32_t alignment = 1, padding = 0;
};

// The descriptions of the inputs in full. An input whose info has WEIR_RANK_UNKNOWN takes the
// shape of `current`; else its shape must fit `declared`. Sizes are checked. SPEC_MISMATCH,
// FRAME_SIZE with the tensor's name.
Result<std::vector<weir_tensor_info>> described_inputs(
    std::span<const weir_tensor> given, const std::vector<weir_tensor_info>& declared,
    const std::vector<weir_tensor_info>& current);

// The shapes that `wanted` puts in place of what the model leaves open; of it type, rank and shape
// are read. WEIR_RANK_UNKNOWN and WEIR_TYPE_END: as the model says. SPEC_MISMATCH.
Result<std::vector<weir_tensor_info>> reshaped(const std::vector<weir_tensor_info>& declared,
                                               std::span<const weir_tensor_info> wanted);

// Memory that a program lends for outputs, which may be open. SPEC_MISMATCH, FRAME_SIZE.
Status check_outputs(std::span<const weir_tensor> given,
                     const std::vector<weir_tensor_info>& outputs);

// Of one tensor; `role` and `index` for the words.
Status check_type(const weir_tensor& given, const weir_tensor_info& model, const char* role,
                  size_t index);
Status check_size(const weir_tensor& given, const weir_tensor_info& needed, const char* role,
                  size_t index);

// Memory of its own that holds inputs. `lasting`: also those that the engine could read in place.
class Inputs {
 public:
  static Result<Inputs> take(std::span<const weir_tensor> given,
                             const std::vector<weir_tensor_info>& infos, const MemoryNeeds& needs,
                             bool lasting);
  std::vector<weir_tensor>& tensors() noexcept { return tensors_; }

 private:
  std::vector<weir_tensor> tensors_;
  Results copies_;
};

}  // namespace weir::direct
