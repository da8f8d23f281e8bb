// RequestOutcomes: what became of the requests of a query client, and how long responses took.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>

namespace weir::edge {

// At the end of a stream sent = answered + late + refused + lost.
struct OutcomeCounts {
  uint64_t sent = 0;
  uint64_t answered = 0;  // within the time-out
  uint64_t late = 0;      // not within the time-out
  uint64_t refused = 0;   // the server ended the connection with ERROR
  uint64_t lost = 0;      // the connection broke, or the stream ended or was flushed
};

// Any thread.
class RequestOutcomes {
 public:
  using Duration = std::chrono::steady_clock::duration;
  static constexpr size_t kKept = 1024, kMin = 8;

  void reset() noexcept {
    const std::lock_guard lock(mutex_);
    counts_ = {};
    responses_ = 0;
  }
  void sent() noexcept { add(&OutcomeCounts::sent, 1); }
  void late(uint64_t requests) noexcept { add(&OutcomeCounts::late, requests); }
  void refused(uint64_t requests) noexcept { add(&OutcomeCounts::refused, requests); }
  void lost(uint64_t requests) noexcept { add(&OutcomeCounts::lost, requests); }
  // A response that came `took` after its request; a late one has been counted before.
  void answered(Duration took, bool is_late) noexcept {
    const std::lock_guard lock(mutex_);
    if (!is_late) ++counts_.answered;
    took_[responses_++ % kKept] = took;
  }

  OutcomeCounts counts() const noexcept {
    const std::lock_guard lock(mutex_);
    return counts_;
  }
  // The time that `percent` of the last responses did not exceed; nullopt for fewer than 8
  // responses.
  std::optional<Duration> percentile(size_t percent) const noexcept {
    const std::lock_guard lock(mutex_);
    if (responses_ < kMin) return std::nullopt;
    auto sorted = took_;
    const size_t n = std::min<size_t>(responses_, kKept), at = n * percent / 100;
    std::nth_element(sorted.begin(), sorted.begin() + at, sorted.begin() + n);
    return sorted[at];
  }

 private:
  void add(uint64_t OutcomeCounts::*count, uint64_t requests) noexcept {
    const std::lock_guard lock(mutex_);
    counts_.*count += requests;
  }

  mutable std::mutex mutex_;  // guards the rest
  OutcomeCounts counts_;
  std::array<Duration, kKept> took_{};
  uint64_t responses_ = 0;
};

}  // namespace weir::edge
