// A logarithmic histogram and the two moving averages of docs/compatibility/filter.md 4.7.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/model/invoke_statistics.hpp"

#include <algorithm>
#include <bit>
#include <climits>
#include <cmath>
#include <utility>

namespace weir::infer {
namespace {

constexpr uint64_t kWindow = 1000;

size_t find_bucket(uint64_t ns) noexcept {
  if (ns < 8) return static_cast<size_t>(ns);
  const int exponent = static_cast<int>(std::bit_width(ns)) - 1;
  return static_cast<size_t>((exponent - 2) * 8) + ((ns >> (exponent - 3)) & 7u);
}
double upper_edge_ns(size_t bucket) noexcept {
  if (bucket < 8) return static_cast<double>(bucket + 1);
  return std::ldexp(1.0 + static_cast<double>(bucket % 8 + 1) / 8,
                    static_cast<int>(bucket / 8) + 2);
}
int to_int(double value) noexcept {
  return value >= INT_MAX ? INT_MAX : static_cast<int>(std::lround(value));
}

}  // namespace

void InvokeStatistics::record(std::chrono::nanoseconds duration) noexcept {
  const auto ns = static_cast<uint64_t>(std::max<int64_t>(duration.count(), 0));
  std::lock_guard lock(mutex_);
  last_ns_ = ns;
  total_ns_ += ns;
  ++histogram_[std::min(find_bucket(ns), kBuckets - 1)];
  if (count_++ == 0) return;
  recent_[(count_ - 2) % recent_.size()] = ns;
  ++window_count_;
  window_ns_ += ns;
  if (window_count_ < kWindow) return;
  old_count_ = std::exchange(window_count_, 0);
  old_ns_ = std::exchange(window_ns_, 0);
}

void InvokeStatistics::reset() noexcept {
  std::lock_guard lock(mutex_);
  count_ = total_ns_ = last_ns_ = window_count_ = window_ns_ = old_count_ = old_ns_ = 0;
  recent_.fill(0);
  histogram_.fill(0);
}

InvokeSnapshot InvokeStatistics::snapshot() const noexcept {
  std::lock_guard lock(mutex_);
  InvokeSnapshot s;
  if (count_ == 0) return s;
  s.count = count_;
  s.last_us = static_cast<double>(last_ns_) / 1e3;
  s.average_us = static_cast<double>(total_ns_) / static_cast<double>(count_) / 1e3;
  const uint64_t wanted = count_ - count_ / 100;
  uint64_t seen = 0;
  for (size_t i = 0; i < kBuckets; ++i) {
    seen += histogram_[i];
    if (seen < wanted) continue;
    s.p99_us = upper_edge_ns(i) / 1e3;
    break;
  }
  return s;
}

std::optional<uint64_t> InvokeStatistics::latency_ns() const noexcept {
  std::lock_guard lock(mutex_);
  if (count_ < 2) return std::nullopt;
  const auto n = std::min<uint64_t>(count_ - 1, recent_.size());
  uint64_t sum = 0;
  for (uint64_t i = 0; i < n; ++i) sum += recent_[i];
  return sum / n;
}

int InvokeStatistics::latency_us() const noexcept {
  const auto ns = latency_ns();
  return ns ? to_int(static_cast<double>(*ns) / 1e3) : -1;
}

int InvokeStatistics::throughput_milli() const noexcept {
  std::lock_guard lock(mutex_);
  const uint64_t n = window_count_ + old_count_, ns = window_ns_ + old_ns_;
  if (n == 0) return -1;
  return to_int(static_cast<double>(n) * 1e12 / static_cast<double>(std::max<uint64_t>(ns, 1)));
}

}  // namespace weir::infer
