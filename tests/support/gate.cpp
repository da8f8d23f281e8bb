// Implements the gate of the engine `gated`.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gate.hpp"

#include <algorithm>

namespace weir::test {

Gate& Gate::of_process() {
  static Gate gate;
  return gate;
}

void Gate::reset(bool open) {
  std::lock_guard lock(mutex_);
  open_ = open;
  let_go_.clear();
  entered_.clear();
  const int models = seen_.models, sessions = seen_.sessions;
  seen_ = {models, sessions, 0, 0, {}};
  changed_.notify_all();
}
void Gate::open() {
  std::lock_guard lock(mutex_);
  open_ = true;
  changed_.notify_all();
}
void Gate::let_go(float frame) {
  std::lock_guard lock(mutex_);
  let_go_.insert(frame);
  changed_.notify_all();
}
std::vector<float> Gate::wait_for_entered(size_t count) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return entered_.size() >= count; });
  return entered_;
}
std::vector<float> Gate::entered() {
  std::lock_guard lock(mutex_);
  return entered_;
}
Gate::Seen Gate::seen() {
  std::lock_guard lock(mutex_);
  return seen_;
}

void Gate::opened(int threads) {
  std::lock_guard lock(mutex_);
  ++seen_.models;
  seen_.threads_wanted.push_back(threads);
}
void Gate::closed() {
  std::lock_guard lock(mutex_);
  --seen_.models;
}
void Gate::session(int by) {
  std::lock_guard lock(mutex_);
  seen_.sessions += by;
}
void Gate::enter(float frame, int* in_session) {
  std::unique_lock lock(mutex_);
  entered_.push_back(frame);
  seen_.max_at_once = std::max(seen_.max_at_once, ++at_once_);
  seen_.max_in_a_session = std::max(seen_.max_in_a_session, ++*in_session);
  changed_.notify_all();
  changed_.wait(lock, [&] { return open_ || let_go_.contains(frame); });
  --at_once_;
  --*in_session;
}

}  // namespace weir::test
