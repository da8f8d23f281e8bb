// InvokeStatistics: measures the duration of invokes. Thread-safe; does not allocate.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>

namespace weir::infer {

struct InvokeSnapshot {
  uint64_t count = 0;  // invokes, including the first (warm-up)
  double last_us = 0, average_us = 0;
  double p99_us = 0;  // upper edge of the bucket, at most 9 % above the true value
};

class InvokeStatistics {
 public:
  void record(std::chrono::nanoseconds duration) noexcept;
  void reset() noexcept;
  InvokeSnapshot snapshot() const noexcept;
  // Mean of the last 10 invokes without the first; nullopt before the second.
  std::optional<uint64_t> latency_ns() const noexcept;
  // docs/compatibility/filter.md 4.7; ignores the first invoke. -1 before the second.
  int latency_us() const noexcept;        // mean of the last 10
  int throughput_milli() const noexcept;  // invokes per second x 1000, over the last 1000 to 2000

 private:
  static constexpr size_t kBuckets = 512;  // 8 per doubling of nanoseconds
  mutable std::mutex mutex_;               // guards the rest
  uint64_t count_ = 0, total_ns_ = 0, last_ns_ = 0;
  uint64_t window_count_ = 0, window_ns_ = 0, old_count_ = 0, old_ns_ = 0;
  std::array<uint64_t, 10> recent_{};
  std::array<uint32_t, kBuckets> histogram_{};
};

}  // namespace weir::infer
