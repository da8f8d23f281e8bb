// Frames over threads.
#include "core/preprocess/runner.hpp"

#include <algorithm>
#include <exception>

namespace weir::preprocess {

Runner::Runner(size_t threads) {
  threads = std::clamp<size_t>(threads, 1, kThreadLimit);
  workspaces_.resize(threads);
  threads_.reserve(threads - 1);
  try {
    while (threads_.size() + 1 < threads)
      threads_.emplace_back(&Runner::work, this, threads_.size() + 1);
  } catch (const std::exception&) {  // no more threads to be had
  }
}

Runner::~Runner() {
  {
    std::lock_guard lock(mutex_);
    ending_ = true;
  }
  begun_.notify_all();
  for (auto& thread : threads_) thread.join();
}

// The jobs were checked: no thread has an error to tell.
void Runner::run_part(size_t part, const Planes& planes, std::span<const Job> jobs) {
  const uint64_t parts = threads_.size() + 1;
  for (const Job& job : jobs) {
    const uint64_t height = job.plan->preparation().height;
    const auto first = static_cast<uint32_t>(height * part / parts);
    const auto end = static_cast<uint32_t>(height * (part + 1) / parts);
    if (first == end) continue;
    [[maybe_unused]] const Status checked =
        job.plan->run_rows(planes, job.out, first, end - first, &workspaces_[part]);
  }
}

Status Runner::run(const Planes& planes, std::span<const Job> jobs) {
  for (const Job& job : jobs) {
    if (auto status = job.plan->run_rows(planes, job.out, 0, 0, &workspaces_[0]); !status)
      return status;
    for (Workspace& workspace : workspaces_) job.plan->grow(&workspace);
  }
  if (threads_.empty()) {
    run_part(0, planes, jobs);
    return ok();
  }
  {
    std::lock_guard lock(mutex_);
    planes_ = &planes;
    jobs_ = jobs;
    working_ = threads_.size();
    ++frame_;
  }
  begun_.notify_all();
  run_part(0, planes, jobs);
  std::unique_lock lock(mutex_);
  done_.wait(lock, [this] { return working_ == 0; });
  return ok();
}

void Runner::work(size_t part) {
  uint64_t last = 0;
  while (true) {
    const Planes* planes = nullptr;
    std::span<const Job> jobs;
    {
      std::unique_lock lock(mutex_);
      begun_.wait(lock, [&] { return ending_ || frame_ != last; });
      if (ending_) return;
      last = frame_;
      planes = planes_;
      jobs = jobs_;
    }
    run_part(part, *planes, jobs);
    std::lock_guard lock(mutex_);
    if (--working_ == 0) done_.notify_one();
  }
}

}  // namespace weir::preprocess
