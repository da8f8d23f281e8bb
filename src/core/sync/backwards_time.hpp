// Detects, reports and optionally drops frames whose timestamps go backwards.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>

#include "weir/result.hpp"

namespace weir {

// The property on-backwards-time: whether a frame with an earlier time than the previous frame
// passes or is dropped.
enum class OnBackwardsTime { Pass, Drop };

// Watches the timestamps of one stream, in nanoseconds.
class BackwardsTimeWatch {
 public:
  // Returns the previous time if `time` is earlier. The next call compares with a frame that
  // passed, not with a dropped one.
  std::optional<uint64_t> check(uint64_t time, OnBackwardsTime what) noexcept {
    const auto before = last_;
    const bool backwards = before && time < *before;
    if (!backwards || what == OnBackwardsTime::Pass) last_ = time;
    return backwards ? before : std::nullopt;
  }
  void reset() noexcept { last_.reset(); }  // the next time starts a new sequence

 private:
  std::optional<uint64_t> last_;
};

// TIME_INVALID: names both times, whether the frame is dropped, and the property.
Error backwards_time(uint64_t time, uint64_t before, OnBackwardsTime what);

}  // namespace weir
