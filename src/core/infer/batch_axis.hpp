// On which axis of a model's tensors the frames of a batch lie.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::infer {

// The axis of each tensor, counted from the outermost.
struct BatchAxes {
  std::vector<uint32_t> inputs, outputs;
  bool fixed = false;  // the model takes batch-size frames, no more and no less
};

// The axis that the engine says or else the outermost, when it is open, or `batch_size` long, in
// every tensor. BATCH_UNSUPPORTED for a model with state (`flags` of weir_model_info) or without
// such an axis. batch_size >= 2.
Result<BatchAxes> find_batch_axes(uint32_t flags, const std::vector<weir_tensor_info>& inputs,
                                  const std::vector<weir_tensor_info>& outputs, size_t batch_size);

// The tensors of one frame: a length that the model fixes to batch_size is 1 for its frames.
std::vector<weir_tensor_info> of_one_frame(std::vector<weir_tensor_info> tensors,
                                           const std::vector<uint32_t>& axes, size_t batch_size);
// Of `frames` frames, all of whose lengths on the axis are known.
std::vector<weir_tensor_info> of_frames(std::vector<weir_tensor_info> tensors,
                                        const std::vector<uint32_t>& axes, size_t frames);

// All lengths are known, all at least 1.
struct BatchShapes {
  BatchAxes axes;
  size_t batch_size = 1;
  std::vector<weir_tensor_info> inputs, outputs;  // of one frame
};

// Says what comes out for these inputs: Session::resolve.
using ResolveShapes =
    std::function<Result<std::vector<weir_tensor_info>>(const std::vector<weir_tensor_info>&)>;

// Asks the model once for one frame and last for a whole batch, and checks that the outputs of
// batch_size frames are batch_size times as long as those of one. BATCH_UNSUPPORTED when they are
// not, or their sizes depend on data; else what `resolve` says.
Result<BatchShapes> shapes_of_batch(const BatchAxes& axes, size_t batch_size,
                                    const std::vector<weir_tensor_info>& frame,
                                    const ResolveShapes& resolve);

}  // namespace weir::infer
