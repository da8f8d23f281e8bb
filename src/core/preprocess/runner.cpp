// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/runner.hpp"

#include <algorithm>
#include <exception>

#include "core/simd/streamed_copy.hpp"

namespace weir::preprocess {
namespace {

// Whether the tensors leave the caches before they are read.
bool are_large(std::span<const Job> jobs) {
  constexpr size_t kBytes = size_t{16} << 20;
  size_t bytes = 0;
  for (const Job& job : jobs) bytes += job.out.size();
  return bytes >= kBytes;
}

struct Rows {
  uint32_t first, count;
};
Rows split_rows(const PreprocessPlan& plan, uint64_t part, uint64_t parts) {
  const uint64_t height = plan.preparation().height;
  const auto first = static_cast<uint32_t>(height * part / parts);
  return {first, static_cast<uint32_t>(height * (part + 1) / parts) - first};
}

}  // namespace

Runner::Runner(size_t threads) {
  threads = std::clamp<size_t>(threads, 1, kThreadLimit);
  workspaces_.resize(threads);
  threads_.reserve(threads - 1);
  try {
    while (threads_.size() + 1 < threads)
      threads_.emplace_back(&Runner::work, this, threads_.size() + 1);
  } catch (const std::exception&) {  // the system has no more threads
  }
}

Runner::~Runner() {
  {
    std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  begun_.notify_all();
  for (auto& thread : threads_) thread.join();
}

// The caller checked the jobs, so run_rows() cannot fail here.
void Runner::run_part(size_t part, const Planes& planes, std::span<const Job> jobs) {
  const uint64_t parts = threads_.size() + 1;
  const bool streamed = are_large(jobs);
  for (const Job& job : jobs) {
    const auto [first, count] = split_rows(*job.plan, part, parts);
    if (count == 0) continue;
    [[maybe_unused]] const Status never_fails = job.plan->run_rows(
        planes, job.out, first, count, &workspaces_[part], {.streamed = streamed, .checked = true});
  }
  if (streamed) flush_streamed();
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
      begun_.wait(lock, [&] { return stopping_ || frame_ != last; });
      if (stopping_) return;
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
