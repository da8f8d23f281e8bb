// SPDX-License-Identifier: LGPL-2.1-or-later
#include "thread_limit.hpp"

#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace weir::engine {

Status check_thread_limit(int threads) {
  const auto wanted = static_cast<size_t>(threads);
  std::mutex gate;  // held until all threads have started
  size_t count = 0;
  {
    std::vector<std::jthread> started;  // joined after the gate opens
    const std::lock_guard closed(gate);
    try {
      started.reserve(wanted);
      while (started.size() < wanted)
        started.emplace_back([&gate] { const std::lock_guard wait(gate); });
    } catch (const std::exception&) {  // std::system_error, or no memory for the thread's state
    }
    count = started.size();
  }
  if (count == wanted) return ok();
  return Error{
      .code = Code::OUT_OF_MEMORY,
      .what = "the system cannot start more threads for the engine",
      .offered = std::to_string(count) + " of " + std::to_string(threads),
      .needed = "memory for their stacks, and a limit of processes (ulimit -u) that is not reached",
      .difference = {},
      .fix = "custom=NumThreads:1"};
}

}  // namespace weir::engine
