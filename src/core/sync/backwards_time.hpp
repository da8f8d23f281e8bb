// Time-stamps that go backwards: noticed, told, and left out where the user wants that.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>

#include "weir/result.hpp"

namespace weir {

// The property on-backwards-time of elements: a frame whose time lies before that of the frame
// ahead of it goes on as it is, or is dropped.
enum class OnBackwardsTime { Pass, Drop };

// Watches the times of one stream; nanoseconds.
class BackwardsTimeWatch {
 public:
  // The time that came before, when `time` lies before it. What passes is what the next one is
  // compared with; what is dropped is not.
  std::optional<uint64_t> check(uint64_t time, OnBackwardsTime what) noexcept {
    const auto before = last_;
    const bool backwards = before && time < *before;
    if (!backwards || what == OnBackwardsTime::Pass) last_ = time;
    return backwards ? before : std::nullopt;
  }
  void reset() noexcept { last_.reset(); }  // the times that follow begin anew

 private:
  std::optional<uint64_t> last_;
};

// TIME_INVALID: names both times, what becomes of such frames, and the property.
Error backwards_time(uint64_t time, uint64_t before, OnBackwardsTime what);

}  // namespace weir
