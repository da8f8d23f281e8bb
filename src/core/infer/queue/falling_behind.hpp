// FallingBehind: detects that frames of a live source arrive later and later. The caller passes the
// time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>

namespace weir::infer {

class FallingBehind {
 public:
  using Duration = std::chrono::nanoseconds;
  static constexpr Duration kLate = std::chrono::seconds(1);
  static constexpr Duration kMinDuration = std::chrono::seconds(2);

  // Records a frame that arrived at `now`, `lag` after its own time, when its receiver had waited
  // `idle` for it. Returns true if all frames were later than kLate for kMinDuration, the last lag
  // is not below the first, which excludes a slow start that is being caught up, and the receiver
  // had hardly time to wait: otherwise the source is late, such as a camera that froze.
  bool observe(Duration now, Duration lag, Duration idle = {}) noexcept {
    if (lag < kLate) {
      late_ = false;
      return false;
    }
    if (!late_) {
      late_ = true;
      since_ = now;
      lag_then_ = lag;
      idle_ = idle = {};
    }
    idle_ += idle;
    if (now - since_ < kMinDuration) return false;
    const bool is_busy = idle_ < (now - since_) / 4;
    const bool later = lag >= lag_then_;
    since_ = now;
    lag_then_ = lag;
    idle_ = {};
    return later && is_busy;
  }
  void reset() noexcept { late_ = false; }

 private:
  bool late_ = false;
  Duration since_{}, lag_then_{}, idle_{};  // while late_
};

}  // namespace weir::infer
