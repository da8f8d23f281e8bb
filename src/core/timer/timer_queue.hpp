// TimerQueue: calls functions at given times, all on one thread.
//
//   TimerQueue::Timer timer(TimerQueue::instance(), [] { ... });
//   timer.start(std::chrono::milliseconds(500));
//
// The clock is a parameter, so that tests can control it and call run_due().
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <condition_variable>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

namespace weir {

// Thread-safe.
class TimerQueue {
 public:
  using Clock = std::chrono::steady_clock;
  using Now = std::function<Clock::time_point()>;

  // The queue of the process; the first timer starts its thread.
  static TimerQueue& instance();
  // A queue without a thread: its owner calls run_due().
  explicit TimerQueue(Now now) : now_(std::move(now)) {}
  ~TimerQueue();  // destroy it after its timers
  TimerQueue(const TimerQueue&) = delete;
  TimerQueue& operator=(const TimerQueue&) = delete;

  class Timer {
   public:
    // `call` should be short, because other timers wait for it. It may restart its own timer.
    Timer(TimerQueue& queue, std::function<void()> call);
    ~Timer();  // waits for a running call; must not be called from that call
    Timer(const Timer&) = delete;
    Timer& operator=(const Timer&) = delete;
    // Calls once after `delay`; replaces an earlier start.
    void start(Clock::duration delay);
    void stop();

   private:
    friend class TimerQueue;
    TimerQueue& queue_;
    const std::function<void()> call_;
    // Guarded by the queue's mutex.
    std::optional<Clock::time_point> due_;
    bool running_ = false;
  };

  Clock::time_point now() const { return now_(); }
  // Calls all due timers without holding a lock; timers started meanwhile wait for the next round.
  void run_due();
  std::optional<Clock::time_point> next() const;

 private:
  void loop();

  const Now now_;
  mutable std::mutex mutex_;         // guards the members below
  std::condition_variable changed_;  // due times, finished calls, stop_
  std::list<Timer*> timers_;
  bool threaded_ = false, stop_ = false;
  std::thread thread_;
};

}  // namespace weir
