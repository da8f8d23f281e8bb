// Checks whether the system can start the threads that an engine needs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/result.hpp"

namespace weir::engine {

// OUT_OF_MEMORY unless `threads` threads can run at once, tested by starting and joining them.
// libpthreadpool, which TensorFlow Lite and libtorch use, waits forever for a thread that could not
// be started, and libgomp aborts the process.
Status check_thread_limit(int threads);

}  // namespace weir::engine
