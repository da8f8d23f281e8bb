// Inputs: checks a program's tensors against the model, and places them in memory that satisfies
// the engine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string>
#include <vector>

#include "core/direct/results.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::direct {

// The engine's memory requirements (weir_model_info), in bytes.
struct MemoryNeeds {
  uint32_t alignment = 1, padding = 0;
};

// Completes the descriptions of the inputs. An input with WEIR_RANK_UNKNOWN takes the shape of
// `current`; others must match `declared`. Checks sizes. SPEC_MISMATCH, FRAME_SIZE with the
// tensor's name.
Result<std::vector<weir_tensor_info>> described_inputs(
    std::span<const weir_tensor> given, const std::vector<weir_tensor_info>& declared,
    const std::vector<weir_tensor_info>& current);

// The shapes with `wanted` in place of what the model leaves open; only its type, rank and shape
// are read. WEIR_RANK_UNKNOWN and WEIR_TYPE_END keep the model's. SPEC_MISMATCH.
Result<std::vector<weir_tensor_info>> reshaped(const std::vector<weir_tensor_info>& declared,
                                               std::span<const weir_tensor_info> wanted);

// Checks memory that a program lends for outputs, which may be open. SPEC_MISMATCH, FRAME_SIZE.
Status check_outputs(std::span<const weir_tensor> given,
                     const std::vector<weir_tensor_info>& outputs);

// For one tensor; `role` and `index` are used in the error text.
Status check_type(const weir_tensor& given, const weir_tensor_info& model, const char* role,
                  size_t index);
Status check_size(const weir_tensor& given, const weir_tensor_info& needed, const char* role,
                  size_t index);

// Owns copies of inputs where necessary. `lasting`: copies also those that the engine could read in
// place.
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
