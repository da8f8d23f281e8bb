// Frames over threads.
#include "core/preprocess/runner.hpp"

#include <algorithm>
#include <exception>

namespace weir::preprocess {

Runner::Runner(Plan plan, size_t threads) : plan_(std::move(plan)) {
  threads = std::clamp<size_t>(threads, 1, kThreadLimit);
  workspaces_.resize(threads);
  threads_.reserve(threads - 1);
  set_plan(plan_);
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

void Runner::set_plan(Plan plan) {
  std::vector<Workspace> workspaces;
  for (size_t part = 0; part < workspaces_.size(); ++part) workspaces.push_back(plan.workspace());
  workspaces_.swap(workspaces);
  plan_ = std::move(plan);
}

Status Runner::run_part(size_t part, const Planes& planes, std::span<std::byte> out) {
  const uint64_t height = plan_.preparation().height, parts = threads_.size() + 1;
  const auto first = static_cast<uint32_t>(height * part / parts);
  const auto end = static_cast<uint32_t>(height * (part + 1) / parts);
  return plan_.run_rows(planes, out, first, end - first, &workspaces_[part]);
}

Status Runner::run(const Planes& planes, std::span<std::byte> out) {
  if (threads_.empty()) return run_part(0, planes, out);
  // Nobody else begins a frame that cannot be done, so that no thread has an error to tell.
  if (auto status = plan_.run_rows(planes, out, 0, 0, &workspaces_[0]); !status) return status;
  {
    std::lock_guard lock(mutex_);
    planes_ = &planes;
    out_ = out;
    working_ = threads_.size();
    ++frame_;
  }
  begun_.notify_all();
  Status status = run_part(0, planes, out);
  std::unique_lock lock(mutex_);
  done_.wait(lock, [this] { return working_ == 0; });
  return status;
}

void Runner::work(size_t part) {
  uint64_t last = 0;
  while (true) {
    const Planes* planes = nullptr;
    std::span<std::byte> out;
    {
      std::unique_lock lock(mutex_);
      begun_.wait(lock, [&] { return ending_ || frame_ != last; });
      if (ending_) return;
      last = frame_;
      planes = planes_;
      out = out_;
    }
    [[maybe_unused]] const Status checked = run_part(part, *planes, out);
    std::lock_guard lock(mutex_);
    if (--working_ == 0) done_.notify_one();
  }
}

}  // namespace weir::preprocess
