// Finds the axis of a model's tensors along which the frames of a batch are concatenated.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::infer {

// The batch axis of each tensor, counted from the outermost.
struct BatchAxes {
  std::vector<uint32_t> inputs, outputs;
  bool fixed = false;  // the model takes exactly batch-size frames
};

// Returns the axis that the engine declares, or else the outermost, if it is open or `batch_size`
// long in every tensor. BATCH_UNSUPPORTED for a stateful model (`flags` of weir_model_info) or one
// without such an axis. Precondition: batch_size >= 2.
Result<BatchAxes> find_batch_axes(uint32_t flags, const std::vector<weir_tensor_info>& inputs,
                                  const std::vector<weir_tensor_info>& outputs, size_t batch_size);

// The tensors of one frame: an extent that the model fixes to batch_size becomes 1.
std::vector<weir_tensor_info> of_one_frame(std::vector<weir_tensor_info> tensors,
                                           const std::vector<uint32_t>& axes, size_t batch_size);
// The tensors of `frames` frames. Precondition: all extents on the axis are known.
std::vector<weir_tensor_info> of_frames(std::vector<weir_tensor_info> tensors,
                                        const std::vector<uint32_t>& axes, size_t frames);

// Shapes of a batch. All extents are known and at least 1.
struct BatchShapes {
  BatchAxes axes;
  size_t batch_size = 1;
  std::vector<weir_tensor_info> inputs, outputs;  // of one frame
};

// Computes the outputs for these inputs: Session::resolve.
using ResolveShapes =
    std::function<Result<std::vector<weir_tensor_info>>(const std::vector<weir_tensor_info>&)>;

// Resolves the shapes of one frame and then of a whole batch, and checks that the outputs of
// batch_size frames are batch_size times as long as those of one. BATCH_UNSUPPORTED if they are not
// or if their sizes depend on data; otherwise errors of `resolve`.
Result<BatchShapes> shapes_of_batch(const BatchAxes& axes, size_t batch_size,
                                    const std::vector<weir_tensor_info>& frame,
                                    const ResolveShapes& resolve);

}  // namespace weir::infer
