// CallThread: runs one call at a time for a caller that waits for a limited time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <functional>
#include <memory>

namespace weir::direct {

class CallThread {
 public:
  CallThread();  // throws std::system_error if no thread can be created
  // Does not wait for a running call: the thread ends with it.
  ~CallThread();
  CallThread(const CallThread&) = delete;
  CallThread& operator=(const CallThread&) = delete;

  // Returns true if `call` ended within the limit. Otherwise it continues alone, so it must own
  // everything that it uses, and later calls wait for it. One caller at a time. `call` must not
  // throw.
  bool run(std::function<void()> call, std::chrono::nanoseconds limit);

 private:
  struct State;
  static void serve(const std::shared_ptr<State>& state);
  std::shared_ptr<State> state_;  // shared with the thread
};

}  // namespace weir::direct
