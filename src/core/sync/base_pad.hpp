// basepad: one output for each frame of one pad, the base.
//
// Step A: current = time of the base's head. End as soon as one pad has ended and is empty.
// Step B, each pad, with window W = min(duration, |base head - base kept| - 1), never below 0, and
// 0 when either is not there:
//   1. head < current: discarded (kept); no output; the round goes on with the same `current`.
//   2. there is a kept frame and |current - head| > W: kept is used, the head stays.
//   3. else the head is popped, kept and used.
// A gap counts as a head that is at gap_end or later. A gap of the base discards what lies before
// its end. A missing pad repeats its kept frame; without one, and when the base is missing, the
// other heads are discarded.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/sync/policy.hpp"

namespace weir::sync {

inline constexpr Time kBaseDuration = 2147483647;  // as if not limited; nanoseconds

// Precondition: base < pads.size().
Decision decide_base_pad(const Round& round, std::span<const PadView> pads, size_t base,
                         Time duration);

}  // namespace weir::sync
