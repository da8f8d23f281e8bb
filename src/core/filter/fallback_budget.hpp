// FallbackBudget: keeps the end of a frame's time free for a second model, by how long that took
// before.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace weir {

// Times are nanoseconds of one clock; `expires`: when the frame becomes useless, 0 = never. One
// thread at a time calls add(); the others are thread-safe.
class FallbackBudget {
 public:
  static constexpr size_t kKept = 16;

  // The second model took this long.
  void add(int64_t took) noexcept {
    kept_[count_++ % kKept] = took;
    max_ = *std::max_element(kept_.begin(), kept_.end());
  }
  // When the first model should end. It may end a little later, so twice the longest of the last 16
  // times is kept free, and a tenth of the time that is left at least. If that is more than there
  // is, the first model gets all.
  int64_t latest_end(int64_t expires, int64_t now) const noexcept {
    if (expires <= 0) return expires;
    const int64_t left = expires - now, spare = std::max<int64_t>(2 * max_, left / 10);
    return spare < left ? expires - spare : expires;
  }
  // Whether the second model can end before the frame expires.
  bool is_enough(int64_t expires, int64_t now) const noexcept {
    return expires <= 0 || now + max_ <= expires;
  }

 private:
  std::array<int64_t, kKept> kept_{};
  size_t count_ = 0;
  std::atomic<int64_t> max_{0};
};

}  // namespace weir
