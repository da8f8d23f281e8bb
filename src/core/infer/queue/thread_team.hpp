// ThreadTeam: a few threads that work on the numbered jobs of one caller.
//
//   ThreadTeam team(2);
//   team.run(parts.size(), [&](size_t thread, size_t part) { ... });
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace weir::infer {

// Used by one thread at a time; that thread works as well.
class ThreadTeam {
 public:
  using Job = std::function<void(size_t thread, size_t number)>;  // must not throw

  // `threads` includes the caller; at least 1. Uses fewer if the system cannot create them.
  explicit ThreadTeam(size_t threads);
  ThreadTeam(const ThreadTeam&) = delete;
  ThreadTeam& operator=(const ThreadTeam&) = delete;
  ~ThreadTeam();

  size_t threads() const noexcept { return threads_.size() + 1; }
  // Starts jobs 0 to count - 1 in this order, each on any free thread (0 is the caller). Returns
  // when all are done; does not wait for threads that have not woken up.
  void run(size_t count, const Job& job);

 private:
  void work(size_t thread);
  void take_all(size_t thread, std::unique_lock<std::mutex>* lock);

  std::mutex mutex_;  // guards the rest except threads_; never held while a job runs
  std::condition_variable begun_, done_;
  const Job* job_ = nullptr;
  size_t count_ = 0, next_ = 0, running_ = 0;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace weir::infer
