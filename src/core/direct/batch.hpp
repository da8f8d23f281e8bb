// Gathering the inputs of several frames along the outermost axis.
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

// `inputs`: frame after frame. Each tensor's shape is that of one frame, 1 in axis 0, or
// WEIR_RANK_UNKNOWN: as `current` with 1 there. BATCH_UNSUPPORTED, and what described_inputs says.
Result<Batch> gather(std::span<const weir_tensor> inputs, uint32_t frames,
                     const weir_model_info& model, const std::vector<weir_tensor_info>& declared,
                     const std::vector<weir_tensor_info>& current);

// Do the outputs of the batch hold its frames in axis 0?
Status check_batched(const std::vector<weir_tensor>& outputs, uint32_t frames);

}  // namespace weir::direct
