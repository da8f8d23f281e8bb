// The first invoke of a session, before frames come: engines allocate and compile in it.
#pragma once
#include <vector>

#include "core/filter/model_shape.hpp"
#include "core/infer/model.hpp"

namespace weir::infer {

// By the engine's own WEIR_WARM, else by an invoke on zeros; nothing is done where a shape is open
// or where zeros would change a state that cannot be reset. What the engine says when it fails.
Status warm_up(Session& session, const std::vector<ModelShape>& inputs,
               const std::vector<ModelShape>& outputs);

}  // namespace weir::infer
