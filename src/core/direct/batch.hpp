// Concatenates the inputs of several frames along the outermost axis.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <vector>

#include "core/direct/results.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::direct {

struct Batch {
  std::vector<weir_tensor_info> infos;  // with the frames in axis 0
  Results memory;
};

// `inputs`: frame after frame. Each tensor has the shape of one frame, 1 in axis 0, or
// WEIR_RANK_UNKNOWN for the shape of `current` with 1 there. BATCH_UNSUPPORTED, and the errors of
// described_inputs.
Result<Batch> gather(std::span<const weir_tensor> inputs, uint32_t frames,
                     const weir_model_info& model, const std::vector<weir_tensor_info>& declared,
                     const std::vector<weir_tensor_info>& current);

// Checks that the outputs of the batch contain its frames in axis 0.
Status check_batched(const std::vector<weir_tensor>& outputs, uint32_t frames);

}  // namespace weir::direct
