// CallGate: guards the calls of an application's function until it is closed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

namespace weir::infer {

// Thread-safe. No lock is held while the function is called.
//
//   const CallGate::Visit visit(gate);
//   if (visit) function(data);
class CallGate {
 public:
  // Blocks new calls and waits for calls on other threads. Does not wait for a call on this thread:
  // a function may close its own gate.
  void close() {
    std::unique_lock lock(mutex_);
    closed_ = true;
    const auto me = std::this_thread::get_id();
    changed_.wait(lock, [&] {
      return std::all_of(inside_.begin(), inside_.end(), [&](auto id) { return id == me; });
    });
  }
  bool is_closed() const {
    std::lock_guard lock(mutex_);
    return closed_;
  }
  // True within a call on this thread.
  bool is_inside() const {
    std::lock_guard lock(mutex_);
    return std::find(inside_.begin(), inside_.end(), std::this_thread::get_id()) != inside_.end();
  }

  // Represents a call for its lifetime. False: the gate is closed; do not call.
  class Visit {
   public:
    explicit Visit(CallGate& gate) : gate_(gate.enter() ? &gate : nullptr) {}
    Visit(const Visit&) = delete;
    Visit& operator=(const Visit&) = delete;
    ~Visit() {
      if (gate_) gate_->leave();
    }
    explicit operator bool() const noexcept { return gate_ != nullptr; }

   private:
    CallGate* gate_;
  };

 private:
  bool enter() {
    std::lock_guard lock(mutex_);
    if (closed_) return false;
    inside_.push_back(std::this_thread::get_id());
    return true;
  }
  void leave() {
    std::lock_guard lock(mutex_);
    inside_.erase(std::find(inside_.begin(), inside_.end(), std::this_thread::get_id()));
    changed_.notify_all();
  }

  mutable std::mutex mutex_;  // guards the rest
  std::condition_variable changed_;
  std::vector<std::thread::id> inside_;
  bool closed_ = false;
};

}  // namespace weir::infer
