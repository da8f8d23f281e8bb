// Starting threads that do nothing.
#include "thread_room.hpp"

#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace weir::engine {

Status check_thread_room(int threads) {
  std::vector<std::thread> started;
  started.reserve(static_cast<size_t>(threads));
  std::mutex gate;  // held until all run
  std::string refused;
  {
    const std::lock_guard closed(gate);
    try {
      while (started.size() < static_cast<size_t>(threads))
        started.emplace_back([&gate] { const std::lock_guard wait(gate); });
    } catch (const std::system_error& e) {
      refused = e.what();
    }
  }
  const size_t count = started.size();
  for (auto& thread : started) thread.join();
  if (refused.empty()) return ok();
  return Error{
      .code = Code::OUT_OF_MEMORY,
      .what = "the system starts no more threads for the engine",
      .offered = std::to_string(count) + " of " + std::to_string(threads) + ": " + refused,
      .needed = "memory for their stacks, and room below the limit of processes (ulimit -u)",
      .difference = {},
      .fix = "custom=NumThreads:1"};
}

}  // namespace weir::engine
