// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/queue/thread_team.hpp"

#include <exception>

namespace weir::infer {

ThreadTeam::ThreadTeam(size_t threads) {
  if (threads > 1) threads_.reserve(threads - 1);
  try {
    while (threads_.size() + 1 < threads)
      threads_.emplace_back(&ThreadTeam::work, this, threads_.size() + 1);
  } catch (const std::exception&) {  // the system has no more threads
  }
}

ThreadTeam::~ThreadTeam() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  begun_.notify_all();
  for (auto& thread : threads_) thread.join();
}

void ThreadTeam::run(size_t count, const Job& job) {
  std::unique_lock lock(mutex_);
  job_ = &job;
  count_ = count;
  next_ = 0;
  if (count > 1) begun_.notify_all();
  take_all(0, &lock);
  done_.wait(lock, [this] { return running_ == 0; });
}

void ThreadTeam::take_all(size_t thread, std::unique_lock<std::mutex>* lock) {
  while (next_ < count_) {
    const Job& job = *job_;
    const size_t number = next_++;
    ++running_;
    lock->unlock();
    job(thread, number);
    lock->lock();
    --running_;
  }
  if (running_ == 0) done_.notify_one();
}

void ThreadTeam::work(size_t thread) {
  std::unique_lock lock(mutex_);
  for (;;) {
    begun_.wait(lock, [this] { return stopping_ || next_ < count_; });
    if (stopping_) return;
    take_all(thread, &lock);
  }
}

}  // namespace weir::infer
