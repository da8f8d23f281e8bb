// UsualWait: how long it is worth looking for an answer before sleeping until it comes.
//
// To sleep and to be woken from another core takes up to 60 us on a virtual machine. Where answers
// come sooner than kMost, as they did of late, who waits looks for one for twice their time; where
// they take longer, the wake-up is little of it, and the core is left to others at once.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <chrono>

namespace weir::isolate {

class UsualWait {
 public:
  using Duration = std::chrono::nanoseconds;
  static constexpr Duration kMost = std::chrono::microseconds(200);

  void took(Duration wait) noexcept {
    usual_ += (std::clamp(wait, Duration::zero(), 2 * kMost) - usual_) / kWeight;
  }
  Duration patience() const noexcept {
    return usual_ < kMost ? std::max(2 * usual_, kLeast) : Duration::zero();
  }

 private:
  static constexpr int kWeight = 4;  // one long wait among short ones changes little
  static constexpr Duration kLeast = std::chrono::microseconds(20);
  Duration usual_ = std::chrono::microseconds(25);
};

}  // namespace weir::isolate
