// WatchedQueue: samples a queue's level at most once per millisecond; at each frame if it leaks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <memory>
#include <vector>

#include "core/trace/recorder.hpp"

namespace weir::tracer {

// Holds no reference to the queue.
class WatchedQueue {
 public:
  explicit WatchedQueue(GstElement* queue);
  ~WatchedQueue();
  WatchedQueue(const WatchedQueue&) = delete;
  WatchedQueue& operator=(const WatchedQueue&) = delete;

  // Only queue, queue2 and multiqueue: they hold none of their locks while they push, so reading
  // their properties is safe. For a multiqueue the frames of all its queues are added, and the
  // fullest one gives the level.
  static bool can_be_watched(GstElement* element);

  void sample(int64_t time, trace::Recorder* recorder) {
    int64_t last = last_.load(std::memory_order_relaxed);
    if (time - last >= period_ &&
        last_.compare_exchange_strong(last, time, std::memory_order_relaxed))
      take(time, recorder);
  }

 private:
  void take(int64_t time, trace::Recorder* recorder);

  const void* const address_;
  const bool several_;                           // a multiqueue: levels are read from its pads
  static constexpr int64_t kPeriod = 1'000'000;  // ns
  GWeakRef queue_;
  std::atomic<int64_t> period_ = kPeriod;  // 0 for a leaky queue, whose losses cannot be counted
  std::atomic<int64_t> last_ = -kPeriod;
};

}  // namespace weir::tracer
