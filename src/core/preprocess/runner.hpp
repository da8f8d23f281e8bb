// Runner: the memory and the threads that run plans.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

#include "core/preprocess/plan.hpp"

namespace weir::preprocess {

inline constexpr size_t kThreadLimit = 64;

// A plan and the tensor that it writes.
struct Job {
  const Plan* plan = nullptr;
  std::span<std::byte> out;
};

// Called from one thread at a time; that thread works too. The rows of each tensor are shared out
// in equal parts, so that the result does not depend on the number of threads.
class Runner {
 public:
  // `threads`: with the caller's, 1 to kThreadLimit. Fewer are used where the system gives no more.
  explicit Runner(size_t threads);
  Runner(const Runner&) = delete;
  Runner& operator=(const Runner&) = delete;
  ~Runner();

  // All jobs are of one picture. Errors: Plan::run_rows() of any job; then nothing is written.
  // Allocates only for plans that are bigger than those before.
  Status run(const Planes& planes, std::span<const Job> jobs);

 private:
  void work(size_t part);
  void run_part(size_t part, const Planes& planes, std::span<const Job> jobs);

  std::vector<Workspace> workspaces_;  // by part; part 0 is the caller's
  std::vector<FrameSums> sums_;        // by part
  std::mutex mutex_;                   // guards the rest but for threads_
  std::condition_variable begun_, done_;
  const Planes* planes_ = nullptr;
  std::span<const Job> jobs_;
  uint64_t frame_ = 0;
  size_t working_ = 0;
  bool ending_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace weir::preprocess
