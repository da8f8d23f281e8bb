// Latencies: the last times that a server took, for their percentiles.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <array>
#include <chrono>
#include <optional>

namespace weir::net {

// Not thread-safe.
class Latencies {
 public:
  using Duration = std::chrono::steady_clock::duration;
  static constexpr size_t kKept = 256, kMin = 8;

  void add(Duration took) noexcept {
    kept_[count_ % kKept] = took;
    ++count_;
  }
  // `percent`: 0 to 99. nullopt for fewer than 8 requests.
  std::optional<Duration> percentile(size_t percent) const noexcept {
    if (count_ < kMin) return std::nullopt;
    auto sorted = kept_;
    const size_t n = std::min(count_, kKept), at = n * percent / 100;
    std::nth_element(sorted.begin(), sorted.begin() + at, sorted.begin() + n);
    return sorted[at];
  }

 private:
  std::array<Duration, kKept> kept_{};
  size_t count_ = 0;
};

}  // namespace weir::net
