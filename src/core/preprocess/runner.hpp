// Runner: a plan with the memory and the threads that run it.
#pragma once
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

#include "core/preprocess/plan.hpp"

namespace weir::preprocess {

inline constexpr size_t kThreadLimit = 64;

// Called from one thread at a time; that thread works too. The rows of the tensor are shared out
// in equal parts, so that the result does not depend on the number of threads.
class Runner {
 public:
  // `threads`: with the caller's, 1 to kThreadLimit. Fewer are used where the system gives no more.
  Runner(Plan plan, size_t threads);
  Runner(const Runner&) = delete;
  Runner& operator=(const Runner&) = delete;
  ~Runner();

  const Plan& plan() const noexcept { return plan_; }
  void set_plan(Plan plan);
  // Errors: Plan::run_rows(). Allocates nothing when all is well.
  Status run(const Planes& planes, std::span<std::byte> out);

 private:
  void work(size_t part);
  Status run_part(size_t part, const Planes& planes, std::span<std::byte> out);

  Plan plan_;
  std::vector<Workspace> workspaces_;  // by part; part 0 is the caller's
  std::mutex mutex_;                   // guards the rest but for threads_
  std::condition_variable begun_, done_;
  const Planes* planes_ = nullptr;
  std::span<std::byte> out_;
  uint64_t frame_ = 0;
  size_t working_ = 0;
  bool ending_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace weir::preprocess
