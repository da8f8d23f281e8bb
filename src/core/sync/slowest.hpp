// slowest: as many outputs as the slowest pad has frames, each with the nearest frames of the
// others.
//
// While a pad is waited for, heads before `current` are discarded (kept), as step B would do later.
// Step A: current = max(current, times of all heads). Ends as soon as one pad has ended and is
// empty. Step B, for each pad:
//   1. head < current: discards (keeps) it; no output; the round repeats with the same `current`.
//   2. the kept frame is nearer to current than the head: uses the kept frame; the head stays.
//   3. else pops, keeps and uses the head.
// A gap counts as a head at gap_end or later: it changes when pairs are known, never which ones. A
// missing pad repeats its kept frame; without one the other heads are discarded.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/sync/policy.hpp"

namespace weir::sync {
Decision decide_slowest(const Round& round, std::span<const PadView> pads);
}  // namespace weir::sync
