// AdaptivePoll: how long to poll for a reply before sleeping until it arrives.
//
// Sleeping and waking from another core takes up to 60 us on a virtual machine. If recent replies
// took less than kMax, the reader polls for twice their mean time. If they took longer, the
// wake-up is a small part of the total, and the reader sleeps immediately to free the core.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <chrono>

namespace weir::isolate {

class AdaptivePoll {
 public:
  using Duration = std::chrono::nanoseconds;
  static constexpr Duration kMax = std::chrono::microseconds(200);

  void took(Duration wait) noexcept {
    usual_ += (std::clamp(wait, Duration::zero(), 2 * kMax) - usual_) / kWeight;
  }
  Duration poll_time() const noexcept {
    return usual_ < kMax ? std::max(2 * usual_, kMin) : Duration::zero();
  }

 private:
  static constexpr int kWeight = 4;  // one long wait among short ones changes little
  static constexpr Duration kMin = std::chrono::microseconds(20);
  Duration usual_ = std::chrono::microseconds(25);
};

}  // namespace weir::isolate
