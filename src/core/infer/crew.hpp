// Crew: a few threads that share out the numbered jobs of one caller.
//
//   Crew crew(2);
//   crew.run(parts.size(), [&](size_t thread, size_t part) { ... });
#pragma once
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace weir::infer {

// Called from one thread at a time; that thread works too.
class Crew {
 public:
  using Job = std::function<void(size_t thread, size_t number)>;  // must not throw

  // `threads`: with the caller's, at least 1. Fewer are used where the system gives no more.
  explicit Crew(size_t threads);
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;
  ~Crew();

  size_t threads() const noexcept { return threads_.size() + 1; }
  // Jobs 0 to count - 1, in this order, each on whichever thread is free (0 is the caller's).
  // Returns when all are done: a thread that does not wake in time is not waited for.
  void run(size_t count, const Job& job);

 private:
  void work(size_t thread);
  void take_all(size_t thread, std::unique_lock<std::mutex>* lock);

  std::mutex mutex_;  // guards the rest but threads_; never held while a job runs
  std::condition_variable begun_, done_;
  const Job* job_ = nullptr;
  size_t count_ = 0, next_ = 0, running_ = 0;
  bool ending_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace weir::infer
