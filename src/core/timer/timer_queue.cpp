// Runs timers on one thread that sleeps until the next one is due.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/timer/timer_queue.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/timer/deadline.hpp"

namespace weir {

TimerQueue& TimerQueue::instance() {
  static TimerQueue queue(Clock::now);
  std::lock_guard lock(queue.mutex_);
  queue.threaded_ = true;
  return queue;
}

TimerQueue::~TimerQueue() {
  {
    std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

TimerQueue::Timer::Timer(TimerQueue& queue, std::function<void()> call)
    : queue_(queue), call_(std::move(call)) {
  std::lock_guard lock(queue_.mutex_);
  queue_.timers_.push_back(this);
  if (queue_.threaded_ && !queue_.thread_.joinable())
    queue_.thread_ = std::thread([&queue] { queue.loop(); });
}

TimerQueue::Timer::~Timer() {
  std::unique_lock lock(queue_.mutex_);
  due_.reset();
  queue_.changed_.wait(lock, [this] { return !running_; });
  queue_.timers_.remove(this);
}

void TimerQueue::Timer::start(Clock::duration delay) {
  const auto due = deadline_after(queue_.now(), delay);
  {
    std::lock_guard lock(queue_.mutex_);
    due_ = due;
  }
  queue_.changed_.notify_all();
}

void TimerQueue::Timer::stop() {
  std::lock_guard lock(queue_.mutex_);
  due_.reset();
}

std::optional<TimerQueue::Clock::time_point> TimerQueue::next() const {
  std::lock_guard lock(mutex_);
  std::optional<Clock::time_point> first;
  for (const Timer* timer : timers_)
    if (timer->due_ && (!first || *timer->due_ < *first)) first = timer->due_;
  return first;
}

void TimerQueue::run_due() {
  std::unique_lock lock(mutex_);
  const auto now = now_();
  // Timers may be destroyed during a call, so the list is searched again after each call.
  const auto due = [now](const Timer* timer) { return timer->due_ && *timer->due_ <= now; };
  for (size_t max = timers_.size(); max > 0; --max) {
    const auto found = std::find_if(timers_.begin(), timers_.end(), due);
    if (found == timers_.end()) return;
    Timer* timer = *found;
    timer->due_.reset();
    timer->running_ = true;
    lock.unlock();
    timer->call_();
    lock.lock();
    timer->running_ = false;
    changed_.notify_all();
  }
}

void TimerQueue::loop() {
  std::unique_lock lock(mutex_);
  while (!stop_) {
    lock.unlock();
    run_due();
    const auto at = next();
    lock.lock();
    if (stop_) return;
    // Due times are compared under the lock, so a start() after next() is noticed.
    const auto earlier = [&] {
      return stop_ || std::any_of(timers_.begin(), timers_.end(), [&](const Timer* timer) {
               return timer->due_ && (!at || *timer->due_ < *at);
             });
    };
    if (at)
      changed_.wait_until(lock, *at, earlier);
    else
      changed_.wait(lock, earlier);
  }
}

}  // namespace weir
