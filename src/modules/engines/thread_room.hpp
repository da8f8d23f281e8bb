// Whether the system starts as many threads as an engine is about to start.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/result.hpp"

namespace weir::engine {

// OUT_OF_MEMORY unless `threads` threads can run at once: it starts them and joins them.
// libpthreadpool, which TensorFlow Lite and libtorch use, waits for ever for a thread that could
// not be started, and libgomp ends the process.
Status check_thread_room(int threads);

}  // namespace weir::engine
