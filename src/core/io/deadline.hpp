// Deadlines and their conversion to time-outs of poll().
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <chrono>
#include <climits>
#include <cstdint>
#include <optional>

namespace weir::io {

using Deadline = std::optional<std::chrono::steady_clock::time_point>;  // nullopt: never

// `times` * `time` after `now`; nullopt if that is beyond the range of the clock.
inline Deadline deadline_in(
    std::chrono::milliseconds time, int times = 1,
    std::chrono::steady_clock::time_point now = std::chrono::steady_clock::now()) noexcept {
  using std::chrono::steady_clock;
  const auto max =
      std::chrono::floor<std::chrono::milliseconds>(steady_clock::time_point::max() - now);
  if (time > max / times) return std::nullopt;
  return now + times * time;
}

// For poll(): -1 (no limit) only without a deadline, 0 when it has passed. Rounded up, so that a
// time-out is not before the deadline; distant deadlines are clamped, so poll() may return before
// them.
inline int poll_timeout(const Deadline& deadline, std::chrono::steady_clock::time_point now =
                                                      std::chrono::steady_clock::now()) noexcept {
  if (!deadline) return -1;
  if (*deadline <= now) return 0;
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(*deadline - now).count();
  return static_cast<int>(std::min<int64_t>(left, INT_MAX));
}

// The one that comes first.
inline Deadline earlier(const Deadline& a, const Deadline& b) noexcept {
  if (!a || !b) return a ? a : b;
  return std::min(*a, *b);
}

// True if the deadline has passed.
inline bool is_over(const Deadline& deadline) noexcept {
  return deadline && std::chrono::steady_clock::now() >= *deadline;
}

}  // namespace weir::io
