// CallThread: runs one call at a time, for a caller that stops waiting when a limit has passed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <functional>
#include <memory>

namespace weir::direct {

class CallThread {
 public:
  CallThread();  // throws std::system_error when no thread can be made
  // Does not wait for a call that goes on: its thread ends with it.
  ~CallThread();
  CallThread(const CallThread&) = delete;
  CallThread& operator=(const CallThread&) = delete;

  // True when `call` ended within the limit. False: it goes on alone, so whatever it touches must
  // be its own, and calls that are given later wait for it. One caller at a time. `call` must not
  // throw.
  bool run(std::function<void()> call, std::chrono::nanoseconds limit);

 private:
  struct State;
  static void serve(const std::shared_ptr<State>& state);
  std::shared_ptr<State> state_;  // the thread's too
};

}  // namespace weir::direct
