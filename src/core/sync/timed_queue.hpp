// TimedQueue<Item>: finds the item with a picture's time among those that another thread delivers.
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
// Longer waits would exceed the clock's range.
inline constexpr std::chrono::nanoseconds kMaxTimedWait = std::chrono::hours(24);

enum class TimedOutcome {
  Found,    // an item with the same time
  None,     // a later item or the end arrived: none with this time will follow
  Late,     // no item arrived in time
  Flushed,  // the taker must return
};

// Times are nanoseconds of one clock for pictures and items, and go back only after a flush. Use
// one thread to deliver and one to take.
template <class Item>
class TimedQueue {
 public:
  // Beyond the limit, removes the oldest item. More items may follow after end().
  void push(int64_t time, Item item) {
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
  // No item before `time` will arrive.
  void advance(int64_t time) {
    std::lock_guard lock(mutex_);
    reached_ = std::max(reached_, time);
    changed_.notify_all();
  }
  // No item will arrive until the next bring() or clear().
  void end() {
    std::lock_guard lock(mutex_);
    ended_ = true;
    changed_.notify_all();
  }
  // Removes older items and waits at most `max` for one with this time; `out` is a default Item if
  // none is found.
  TimedOutcome take(int64_t time, std::chrono::nanoseconds max, Item* out) {
    *out = Item();
    std::unique_lock lock(mutex_);
    const auto decided = [&] {
      while (!items_.empty() && items_.front().time < time) {
        items_.pop_front();
        ++unused_;
      }
      return flushing_ || ended_ || !items_.empty() || reached_ > time;
    };
    const bool in_time = changed_.wait_for(lock, std::min(max, kMaxTimedWait), decided);
    if (flushing_) return TimedOutcome::Flushed;
    if (!items_.empty() && items_.front().time == time) {
      *out = std::move(items_.front().item);
      items_.pop_front();
      return TimedOutcome::Found;
    }
    return in_time ? TimedOutcome::None : TimedOutcome::Late;
  }
  // While on, take() returns at once and new items count as unused.
  void flush(bool on) {
    std::lock_guard lock(mutex_);
    flushing_ = on;
    changed_.notify_all();
  }
  // For a new stream: removes all items; items may arrive again.
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
  uint64_t unused() const {  // items that matched no picture
    std::lock_guard lock(mutex_);
    return unused_;
  }

 private:
  struct Timed {
    int64_t time;
    Item item;
  };
  mutable std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  std::deque<Timed> items_;
  int64_t reached_ = INT64_MIN;  // new items have this time or a later one
  bool ended_ = false, flushing_ = false;
  uint64_t unused_ = 0;
};

}  // namespace weir::sync
