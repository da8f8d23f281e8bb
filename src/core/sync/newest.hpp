// Newest<Item>: the newest of what one thread brings, for another that never waits for it.
#pragma once
#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>

namespace weir::sync {

inline constexpr int64_t kNoTime = INT64_MIN;

// Times in nanoseconds, of one clock. What came without a time has that of its first use.
template <class Item>
class Newest {
 public:
  using Held = std::shared_ptr<const Item>;

  void bring(int64_t time, Held item) {
    std::lock_guard lock(mutex_);
    leave(&replaced_);
    item_ = std::move(item);
    time_ = time;
    used_ = false;
  }
  // The item, unless it is farther than `most_apart` (0 = any) from `time`; else null. Without a
  // `time` nothing is too far.
  Held at(int64_t time, uint64_t most_apart) {
    std::lock_guard lock(mutex_);
    if (!item_) return nullptr;
    if (time != kNoTime && time_ == kNoTime) time_ = time;
    if (time != kNoTime && most_apart > 0 && distance(time, time_) > most_apart) return nullptr;
    used_count_ += !used_;
    used_ = true;
    return item_;
  }
  void clear() {
    std::lock_guard lock(mutex_);
    leave(&cleared_);
    item_ = nullptr;
  }
  // Nothing is held, nothing was counted.
  void reset() {
    std::lock_guard lock(mutex_);
    item_ = nullptr;
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
    return {used_count_, replaced_, cleared_, item_ && !used_ ? uint64_t{1} : 0};
  }

 private:
  static uint64_t distance(int64_t a, int64_t b) noexcept {
    return a > b ? static_cast<uint64_t>(a) - static_cast<uint64_t>(b)
                 : static_cast<uint64_t>(b) - static_cast<uint64_t>(a);
  }
  void leave(uint64_t* unused) {
    if (item_ && !used_) ++*unused;
  }

  mutable std::mutex mutex_;  // guards the rest
  Held item_;
  int64_t time_ = kNoTime;
  bool used_ = false;
  uint64_t used_count_ = 0, replaced_ = 0, cleared_ = 0;
};

}  // namespace weir::sync
