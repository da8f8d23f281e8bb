// The batches of a model that filters share: one group for each shape of their frames.
#pragma once
#include <memory>
#include <vector>

#include "core/filter/model_shape.hpp"
#include "core/infer/batch_group.hpp"
#include "core/infer/shared_model.hpp"

namespace weir::infer {

struct ModelBatch {
  std::shared_ptr<BatchGroup> group;
  std::vector<ModelShape> outputs;  // of one frame
};

// The group of `shared` for such frames (all known) and this batch-size; made when none is there.
// It has a session of its own and takes part in replacements of the model between two batches.
// BATCH_UNSUPPORTED as shapes_of_batch(); else what the engine says to these shapes.
Result<ModelBatch> join_model_batch(const std::shared_ptr<SharedModel>& shared,
                                    const BatchAxes& axes, size_t batch_size,
                                    const std::vector<ModelShape>& frame);

}  // namespace weir::infer
