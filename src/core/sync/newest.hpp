// Newest<Item>: passes the newest item of one thread to another one that never waits for it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <utility>

namespace weir::sync {

inline constexpr int64_t kNoTime = INT64_MIN;

// Times are nanoseconds of one clock. An item without a time gets the time of its first use. Items
// later than the requested time are kept until their time is requested.
template <class Item>
class Newest {
 public:
  using Held = std::shared_ptr<const Item>;
  // The oldest items are removed if more arrive ahead of their time.
  static constexpr size_t kMaxHeld = 64;

  void push(int64_t time, Held item) {
    std::lock_guard lock(mutex_);
    held_.push_back({std::move(item), time});
    if (held_.size() > kMaxHeld) leave(1, &replaced_);
  }
  // The newest item not later than `time`; if there is none, the first later one. Null if it is
  // more than `max_apart` (0 = no limit) from `time`. Without a `time`, the newest of all.
  Held at(int64_t time, uint64_t max_apart) {
    std::lock_guard lock(mutex_);
    const auto due = [time](const One& one) { return time == kNoTime || one.time <= time; };
    const auto after = std::find_if(held_.rbegin(), held_.rend(), due).base();
    if (after != held_.begin()) leave(static_cast<size_t>(after - held_.begin()) - 1, &replaced_);
    if (held_.empty()) return nullptr;
    One& one = held_.front();
    if (time != kNoTime && one.time == kNoTime) one.time = time;
    if (time != kNoTime && max_apart > 0 && distance(time, one.time) > max_apart) return nullptr;
    used_count_ += !one.used;
    one.used = true;
    return one.item;
  }
  void clear() {
    std::lock_guard lock(mutex_);
    leave(held_.size(), &cleared_);
  }
  // Removes all items and resets the counts.
  void reset() {
    std::lock_guard lock(mutex_);
    held_.clear();
    replaced_ = cleared_ = used_count_ = 0;
  }

  // Counts each item once: brought = used + replaced + cleared + waiting.
  struct Counts {
    uint64_t used = 0;
    uint64_t replaced = 0, cleared = 0;  // before their first use
    uint64_t waiting = 0;                // for their first use
  };
  Counts counts() const {
    std::lock_guard lock(mutex_);
    return {used_count_, replaced_, cleared_, unused(held_.size())};
  }

 private:
  struct One {
    Held item;
    int64_t time = kNoTime;  // sorts before all others if unset
    bool used = false;
  };
  static uint64_t distance(int64_t a, int64_t b) noexcept {
    return a > b ? static_cast<uint64_t>(a) - static_cast<uint64_t>(b)
                 : static_cast<uint64_t>(b) - static_cast<uint64_t>(a);
  }
  // Unused ones among the `count` oldest items.
  uint64_t unused(size_t count) const {
    const auto end = held_.begin() + static_cast<ptrdiff_t>(count);
    return static_cast<uint64_t>(
        std::count_if(held_.begin(), end, [](const One& one) { return !one.used; }));
  }
  void leave(size_t count, uint64_t* counter) {
    *counter += unused(count);
    held_.erase(held_.begin(), held_.begin() + static_cast<ptrdiff_t>(count));
  }

  mutable std::mutex mutex_;  // guards the members below
  std::deque<One> held_;      // in order of arrival
  uint64_t used_count_ = 0, replaced_ = 0, cleared_ = 0;
};

}  // namespace weir::sync
