// ThreadBudget: how the cores are shared among the models that this process runs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <mutex>
#include <vector>

namespace weir::infer {

// One that runs frames: so many at a time, each with so many threads of the engine.
struct ThreadUse {
  int workers = 1;
  int threads = 0;  // of each worker; 0 = its share
};

// Threads for each worker of `own`, so that all of `others` and it together take no more than
// `cores`; at least 1. 0 = the engine may choose: it is alone, and runs one frame at a time.
int share_of(const ThreadUse& own, const std::vector<ThreadUse>& others, int cores) noexcept;

class ThreadBudget {
  struct Entry;

 public:
  explicit ThreadBudget(int cores) : cores_(cores) {}
  // The cores that this process may use.
  static ThreadBudget& of_process();

  // A place among those that run, as long as it lives.
  class Claim {
   public:
    Claim() = default;

   private:
    friend class ThreadBudget;
    std::shared_ptr<Entry> entry_;
  };
  Claim claim(const ThreadUse& use);
  // What the claim comes to among all that live now.
  int threads_of(const Claim& claim);

 private:
  struct Entry {
    ThreadUse use;
  };
  const int cores_;
  std::mutex mutex_;  // guards entries_
  std::vector<std::weak_ptr<Entry>> entries_;
};

}  // namespace weir::infer
