// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/filter/latency_report.hpp"

#include <algorithm>

namespace weir {
namespace {

// Rounded to the nearest nanosecond; a year is far from overflowing.
uint64_t with_margin(uint64_t average) noexcept {
  const uint64_t bounded = std::min(average, UINT64_MAX / 128);
  return (bounded * 105 + 50) / 100;
}

}  // namespace

uint64_t LatencyReport::update(uint64_t average) noexcept {
  std::lock_guard lock(mutex_);
  return reported_ = with_margin(average);
}

bool LatencyReport::outdated(uint64_t average) noexcept {
  std::lock_guard lock(mutex_);
  const uint64_t bounded = std::min(average, UINT64_MAX / 128);
  const bool much_less = bounded < reported_ && (reported_ - bounded) * 4 > reported_;
  if (bounded <= reported_ && !much_less) return false;
  reported_ = with_margin(bounded);
  return true;
}

void LatencyReport::reset() noexcept {
  std::lock_guard lock(mutex_);
  reported_ = 0;
}

}  // namespace weir
