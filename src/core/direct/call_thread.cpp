// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/direct/call_thread.hpp"

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

#include "core/timer/deadline.hpp"

namespace weir::direct {

struct CallThread::State {
  std::mutex mutex;  // guards the rest
  std::condition_variable changed;
  std::deque<std::function<void()>> calls;  // not started
  uint64_t given = 0, ended = 0;            // calls
  bool leaving = false;
};

CallThread::CallThread() : state_(std::make_shared<State>()) {
  std::thread(serve, state_).detach();
}

CallThread::~CallThread() {
  std::lock_guard lock(state_->mutex);
  state_->leaving = true;
  state_->changed.notify_all();
}

void CallThread::serve(const std::shared_ptr<State>& state) {
  for (;;) {
    std::unique_lock lock(state->mutex);
    state->changed.wait(lock, [&] { return !state->calls.empty() || state->leaving; });
    if (state->calls.empty()) return;
    auto call = std::move(state->calls.front());
    state->calls.pop_front();
    lock.unlock();
    call();
    call = nullptr;  // destroy its captures before it counts as ended
    lock.lock();
    ++state->ended;
    state->changed.notify_all();
  }
}

bool CallThread::run(std::function<void()> call, std::chrono::nanoseconds limit) {
  const auto until = deadline_after(std::chrono::steady_clock::now(), limit);
  std::unique_lock lock(state_->mutex);
  const uint64_t number = ++state_->given;
  state_->calls.push_back(std::move(call));
  state_->changed.notify_all();
  return state_->changed.wait_until(lock, until, [&] { return state_->ended >= number; });
}

}  // namespace weir::direct
