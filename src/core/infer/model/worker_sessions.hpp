// The sessions of a model that several threads invoke concurrently.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <vector>

#include "core/infer/model/model.hpp"

namespace weir::infer {

// Returns one session for each of `workers` threads: a common one if the engine is thread-safe,
// otherwise one each, of this model or, at its limit, of the model opened again. The first may
// have other users. OPTION_VALUE for a stateful model and workers > 1.
Result<std::vector<std::shared_ptr<Session>>> worker_sessions(Model& model, size_t workers);

}  // namespace weir::infer
