// InvokeStatistics: how long invokes take. Thread-safe, allocates nothing.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>

namespace weir::infer {

struct InvokeSnapshot {
  uint64_t count = 0;  // invokes, the first (warming) one too
  double last_us = 0, average_us = 0;
  double p99_us = 0;  // upper edge of the bucket, at most 9 % above the true value
};

class InvokeStatistics {
 public:
  void record(std::chrono::nanoseconds duration) noexcept;
  void reset() noexcept;
  InvokeSnapshot snapshot() const noexcept;
  // Mean of the last 10, the first not counted; none before the second.
  std::optional<uint64_t> latency_ns() const noexcept;
  // Specification 4.7; the first invoke does not count. -1 before the second.
  int latency_us() const noexcept;        // mean of the last 10
  int throughput_milli() const noexcept;  // invokes a second x 1000, of the last 1000 to 2000

 private:
  static constexpr size_t kBuckets = 512;  // 8 for each doubling of nanoseconds
  mutable std::mutex mutex_;               // guards the rest
  uint64_t count_ = 0, total_ns_ = 0, last_ns_ = 0;
  uint64_t window_count_ = 0, window_ns_ = 0, old_count_ = 0, old_ns_ = 0;
  std::array<uint64_t, 10> recent_{};
  std::array<uint32_t, kBuckets> histogram_{};
};

}  // namespace weir::infer
