// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/queue/thread_budget.hpp"

#include <algorithm>

#include "machine/usable_cores.hpp"

namespace weir::infer {
int split_cores(const ThreadUse& own, const std::vector<ThreadUse>& others, int cores) noexcept {
  if (own.threads > 0) return own.threads;
  if (others.empty() && own.workers == 1) return 0;
  int sharing = own.workers, left = cores;
  for (const ThreadUse& other : others) {
    if (other.threads > 0)
      left -= std::min(other.workers * other.threads, left);
    else
      sharing += other.workers;
  }
  return std::max(1, left / sharing);
}

ThreadBudget& ThreadBudget::of_process() {
  static ThreadBudget budget(usable_cores());
  return budget;
}

ThreadBudget::Claim ThreadBudget::claim(const ThreadUse& use) {
  Claim out;
  out.entry_ = std::make_shared<Entry>(Entry{use});
  std::lock_guard lock(mutex_);
  std::erase_if(entries_, [](const auto& entry) { return entry.expired(); });
  entries_.push_back(out.entry_);
  return out;
}

int ThreadBudget::count_threads(const Claim& claim) {
  if (!claim.entry_) return 0;
  std::vector<ThreadUse> others;
  std::lock_guard lock(mutex_);
  for (const auto& weak : entries_)
    if (const auto entry = weak.lock(); entry && entry != claim.entry_)
      others.push_back(entry->use);
  return split_cores(claim.entry_->use, others, cores_);
}

}  // namespace weir::infer
