// ThreadBudget: divides the cores among the models that this process runs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <mutex>
#include <vector>

namespace weir::infer {

// The threads of one running model: workers, and engine threads of each.
struct ThreadUse {
  int workers = 1;
  int threads = 0;  // of each worker; 0 = automatic
};

// Threads for each worker of `own` such that it and all `others` together use at most `cores`; at
// least 1. 0 = the engine may choose, since it is alone and runs one frame at a time.
int split_cores(const ThreadUse& own, const std::vector<ThreadUse>& others, int cores) noexcept;

class ThreadBudget {
  struct Entry;

 public:
  explicit ThreadBudget(int cores) : cores_(cores) {}
  // The budget of the cores that this process may use.
  static ThreadBudget& of_process();

  // Registers a running model for its lifetime.
  class Claim {
   public:
    Claim() = default;

   private:
    friend class ThreadBudget;
    std::shared_ptr<Entry> entry_;
  };
  Claim claim(const ThreadUse& use);
  // The threads of the claim, given all current claims.
  int count_threads(const Claim& claim);

 private:
  struct Entry {
    ThreadUse use;
  };
  const int cores_;
  std::mutex mutex_;  // guards entries_
  std::vector<std::weak_ptr<Entry>> entries_;
};

}  // namespace weir::infer
