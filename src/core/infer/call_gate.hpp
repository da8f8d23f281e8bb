// CallGate: every call of a program's function passes through it until it is closed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

namespace weir::infer {

// Thread-safe. The function is called while no lock is held.
//
//   const CallGate::Visit visit(gate);
//   if (visit) function(data);
class CallGate {
 public:
  // Lets no further call in and waits for the calls of other threads. A call of this very thread
  // goes on: a function may close its own gate.
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
  // True in a call of this thread.
  bool is_inside() const {
    std::lock_guard lock(mutex_);
    return std::find(inside_.begin(), inside_.end(), std::this_thread::get_id()) != inside_.end();
  }

  // A call, for as long as it lives. False: the gate is closed, and nothing may be called.
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
