// basepad: one output for each frame of one pad, the base.
//
// Step A: current = time of the base's head. Ends as soon as one pad has ended and is empty.
// Step B, for each pad, with window W = min(duration, |base head - base kept| - 1), at least 0, and
// 0 if either is missing:
//   1. head < current: discards (keeps) it; no output; the round repeats with the same `current`.
//   2. there is a kept frame and |current - head| > W: uses the kept frame; the head stays.
//   3. else pops, keeps and uses the head.
// A gap counts as a head at gap_end or later. A gap of the base discards the heads before its end.
// A missing pad repeats its kept frame; without one, or if the base is missing, the other heads are
// discarded.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/sync/policy.hpp"

namespace weir::sync {

inline constexpr Time kBaseDuration = 2147483647;  // nanoseconds; practically unlimited

// Precondition: base < pads.size().
Decision decide_base_pad(const Round& round, std::span<const PadView> pads, size_t base,
                         Time duration);

}  // namespace weir::sync
