// TimedQueue<Item>: finds what goes with a picture's time among what another thread brings.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <utility>

namespace weir::sync {

inline constexpr size_t kTimedQueueLimit = 256;  // items that wait for their picture
// Longer waits would be beyond the clock's range.
inline constexpr std::chrono::nanoseconds kLongestTimedWait = std::chrono::hours(24);

enum class TimedOutcome {
  Found,    // an item of the same time
  None,     // one of a later time, or no more of them: none of this time will come
  Late,     // it did not come in time
  Flushed,  // the taker shall go
};

// Times in nanoseconds, of one clock for pictures and items; neither may go back but by a flush.
// One thread brings, one takes.
template <class Item>
class TimedQueue {
 public:
  // Beyond the limit the oldest item goes. After end() more may come.
  void bring(int64_t time, Item item) {
    std::lock_guard lock(mutex_);
    if (flushing_) {
      ++unused_;
      return;
    }
    ended_ = false;
    reached_ = std::max(reached_, time);
    items_.push_back({time, std::move(item)});
    if (items_.size() > kTimedQueueLimit) {
      items_.pop_front();
      ++unused_;
    }
    changed_.notify_all();
  }
  // Nothing before `time` will come.
  void advance(int64_t time) {
    std::lock_guard lock(mutex_);
    reached_ = std::max(reached_, time);
    changed_.notify_all();
  }
  // Nothing at all will come, until something does or clear().
  void end() {
    std::lock_guard lock(mutex_);
    ended_ = true;
    changed_.notify_all();
  }
  // Items of an older time go. Waits for one of this time at most so long; `out` is a new Item
  // where none is found.
  TimedOutcome take(int64_t time, std::chrono::nanoseconds most, Item* out) {
    *out = Item();
    std::unique_lock lock(mutex_);
    const auto decided = [&] {
      while (!items_.empty() && items_.front().time < time) {
        items_.pop_front();
        ++unused_;
      }
      return flushing_ || ended_ || !items_.empty() || reached_ > time;
    };
    const bool in_time = changed_.wait_for(lock, std::min(most, kLongestTimedWait), decided);
    if (flushing_) return TimedOutcome::Flushed;
    if (!items_.empty() && items_.front().time == time) {
      *out = std::move(items_.front().item);
      items_.pop_front();
      return TimedOutcome::Found;
    }
    return in_time ? TimedOutcome::None : TimedOutcome::Late;
  }
  // While on, take() returns at once and what comes is counted as unused.
  void flush(bool on) {
    std::lock_guard lock(mutex_);
    flushing_ = on;
    changed_.notify_all();
  }
  // Of a new stream: all that waits goes, items may come again.
  void clear() {
    std::lock_guard lock(mutex_);
    unused_ += items_.size();
    items_.clear();
    reached_ = INT64_MIN;
    ended_ = false;
    changed_.notify_all();
  }

  uint64_t waiting() const {
    std::lock_guard lock(mutex_);
    return items_.size();
  }
  uint64_t unused() const {  // items that met no picture
    std::lock_guard lock(mutex_);
    return unused_;
  }

 private:
  struct Timed {
    int64_t time;
    Item item;
  };
  mutable std::mutex mutex_;  // guards the rest
  std::condition_variable changed_;
  std::deque<Timed> items_;
  int64_t reached_ = INT64_MIN;  // what comes is of this time or later
  bool ended_ = false, flushing_ = false;
  uint64_t unused_ = 0;
};

}  // namespace weir::sync
