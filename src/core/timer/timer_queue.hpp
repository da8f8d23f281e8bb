// TimerQueue: functions that are called when their time has come, all on one thread.
//
//   TimerQueue::Timer timer(TimerQueue::instance(), [] { ... });
//   timer.start(std::chrono::milliseconds(500));
//
// The clock is given, so that tests move it by hand and call run_due().
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

  // Of the process, with a thread that begins with the first timer.
  static TimerQueue& instance();
  // Without a thread: run_due() is called by its owner.
  explicit TimerQueue(Now now) : now_(std::move(now)) {}
  ~TimerQueue();  // after its timers
  TimerQueue(const TimerQueue&) = delete;
  TimerQueue& operator=(const TimerQueue&) = delete;

  class Timer {
   public:
    // `call` should be short: other timers wait for it. It may start its own timer again.
    Timer(TimerQueue& queue, std::function<void()> call);
    ~Timer();  // waits for a call that goes on; not within that call
    Timer(const Timer&) = delete;
    Timer& operator=(const Timer&) = delete;
    // Calls once, `delay` from now; a time that was set before is forgotten.
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
  // Calls what is due, with no lock held; what is started meanwhile waits for the next round.
  void run_due();
  std::optional<Clock::time_point> next() const;

 private:
  void loop();

  const Now now_;
  mutable std::mutex mutex_;         // guards the rest
  std::condition_variable changed_;  // due times, ends of calls, stop_
  std::list<Timer*> timers_;
  bool threaded_ = false, stop_ = false;
  std::thread thread_;
};

}  // namespace weir
