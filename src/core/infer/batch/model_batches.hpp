// Batches of a model shared by several filters: one group per frame shape.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <vector>

#include "core/filter/model_fit.hpp"
#include "core/infer/batch/batch_group.hpp"
#include "core/infer/model/shared_model.hpp"

namespace weir::infer {

struct ModelBatch {
  std::shared_ptr<BatchGroup> group;
  std::vector<ModelTensor> outputs;  // of one frame
};

// Returns the group of `shared` for these frame shapes (all known) and this batch-size, creating it
// if necessary. The group has its own session, and the model is replaced between two of its
// batches. BATCH_UNSUPPORTED as shapes_of_batch(); otherwise errors of the engine for these shapes.
Result<ModelBatch> join_model_batch(const std::shared_ptr<SharedModel>& shared,
                                    const BatchAxes& axes, size_t batch_size,
                                    const std::vector<ModelTensor>& frame);

}  // namespace weir::infer
