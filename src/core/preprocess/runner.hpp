// Runner: runs the plans of a frame on several threads and owns their memory.
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

// A plan and the tensor that it writes to.
struct Job {
  const PreprocessPlan* plan = nullptr;
  std::span<std::byte> out;
};

// Use from one thread at a time; that thread works too. Each thread gets an equal part of each
// tensor's rows, and the result does not depend on the number of threads.
class Runner {
 public:
  // `threads`: 1 to kThreadLimit, including the caller's. Uses fewer if the system has no more.
  explicit Runner(size_t threads);
  Runner(const Runner&) = delete;
  Runner& operator=(const Runner&) = delete;
  ~Runner();

  // All jobs read one picture. Returns the errors of PreprocessPlan::run_rows(); on error nothing
  // is written. Allocates only for plans that are larger than all earlier ones.
  Status run(const Planes& planes, std::span<const Job> jobs);

 private:
  void work(size_t part);
  void run_part(size_t part, const Planes& planes, std::span<const Job> jobs);

  std::vector<Workspace> workspaces_;  // one for each part; part 0 is the caller's
  std::mutex mutex_;                   // guards the members below except threads_
  std::condition_variable begun_, done_;
  const Planes* planes_ = nullptr;
  std::span<const Job> jobs_;
  uint64_t frame_ = 0;
  size_t working_ = 0;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace weir::preprocess
