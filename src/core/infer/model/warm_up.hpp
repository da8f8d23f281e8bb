// Runs the first invoke of a session, in which engines allocate and compile, before the stream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "core/filter/model_fit.hpp"
#include "core/infer/model/model.hpp"

namespace weir::infer {

// Uses the engine's WEIR_WARM, otherwise an invoke on zeros. Does nothing if a shape is open or if
// zeros would change a state that cannot be reset. Errors of the engine.
Status warm_up(Session& session, const std::vector<ModelTensor>& inputs,
               const std::vector<ModelTensor>& outputs);

// The invoke on zeros. Does nothing in the same cases.
Status invoke_zeros(Session& session, const std::vector<ModelTensor>& inputs,
                    const std::vector<ModelTensor>& outputs);

}  // namespace weir::infer
