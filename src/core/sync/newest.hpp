// Newest<Item>: the newest of what one thread brings, for another that never waits for it.
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

// Times in nanoseconds, of one clock. What came without a time has that of its first use. What is
// of a later time than it is asked for is kept until its time comes.
template <class Item>
class Newest {
 public:
  using Held = std::shared_ptr<const Item>;
  static constexpr size_t kMostHeld = 64;  // the oldest go where more come ahead of their time

  void bring(int64_t time, Held item) {
    std::lock_guard lock(mutex_);
    held_.push_back({std::move(item), time});
    if (held_.size() > kMostHeld) leave(1, &replaced_);
  }
  // The newest item that is not of a later time than `time`; where there is none, the first of the
  // later ones. Null where it is farther than `most_apart` (0 = any) from `time`. Without a `time`
  // it is the newest of all, and nothing is too far.
  Held at(int64_t time, uint64_t most_apart) {
    std::lock_guard lock(mutex_);
    const auto due = [time](const One& one) { return time == kNoTime || one.time <= time; };
    const auto after = std::find_if(held_.rbegin(), held_.rend(), due).base();
    if (after != held_.begin()) leave(static_cast<size_t>(after - held_.begin()) - 1, &replaced_);
    if (held_.empty()) return nullptr;
    One& one = held_.front();
    if (time != kNoTime && one.time == kNoTime) one.time = time;
    if (time != kNoTime && most_apart > 0 && distance(time, one.time) > most_apart) return nullptr;
    used_count_ += !one.used;
    one.used = true;
    return one.item;
  }
  void clear() {
    std::lock_guard lock(mutex_);
    leave(held_.size(), &cleared_);
  }
  // Nothing is held, nothing was counted.
  void reset() {
    std::lock_guard lock(mutex_);
    held_.clear();
    replaced_ = cleared_ = used_count_ = 0;
  }

  // Each item is counted once: brought = used + replaced + cleared + waiting.
  struct Counts {
    uint64_t used = 0;
    uint64_t replaced = 0, cleared = 0;  // before their first use
    uint64_t waiting = 0;                // for it
  };
  Counts counts() const {
    std::lock_guard lock(mutex_);
    return {used_count_, replaced_, cleared_, unused(held_.size())};
  }

 private:
  struct One {
    Held item;
    int64_t time = kNoTime;  // before all others where it has none
    bool used = false;
  };
  static uint64_t distance(int64_t a, int64_t b) noexcept {
    return a > b ? static_cast<uint64_t>(a) - static_cast<uint64_t>(b)
                 : static_cast<uint64_t>(b) - static_cast<uint64_t>(a);
  }
  // Of the `count` oldest.
  uint64_t unused(size_t count) const {
    const auto end = held_.begin() + static_cast<ptrdiff_t>(count);
    return static_cast<uint64_t>(
        std::count_if(held_.begin(), end, [](const One& one) { return !one.used; }));
  }
  void leave(size_t count, uint64_t* counter) {
    *counter += unused(count);
    held_.erase(held_.begin(), held_.begin() + static_cast<ptrdiff_t>(count));
  }

  mutable std::mutex mutex_;  // guards the rest
  std::deque<One> held_;      // in the order in which they came
  uint64_t used_count_ = 0, replaced_ = 0, cleared_ = 0;
};

}  // namespace weir::sync
