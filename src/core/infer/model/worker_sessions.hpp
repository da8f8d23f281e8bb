// The sessions of a model that several threads invoke concurrently.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "core/infer/model/session_pool.hpp"

namespace weir::infer {

// Returns one session for each of `workers` threads: a common one if the engine is thread-safe,
// otherwise one each, from the pool or, at its limit, from the model opened again. The first may
// have other users. OPTION_VALUE for a stateful model and workers > 1.
Result<std::vector<std::shared_ptr<Session>>> worker_sessions(SessionPool& pool, size_t workers);

}  // namespace weir::infer
