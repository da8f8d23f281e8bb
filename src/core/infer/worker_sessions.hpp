// The sessions of a model that several threads invoke at once.
#pragma once
#include <vector>

#include "core/infer/session_pool.hpp"

namespace weir::infer {

// One for each of `workers` threads: the same for all where the engine is thread-safe, else one of
// its own each, of the pool's model or, when that gives no more, of the model opened again. The
// first may have other users too. OPTION_VALUE when the model keeps state from frame to frame and
// workers > 1.
Result<std::vector<std::shared_ptr<Session>>> worker_sessions(SessionPool& pool, size_t workers);

}  // namespace weir::infer
