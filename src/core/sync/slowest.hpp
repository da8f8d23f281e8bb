// slowest: as many outputs as the slowest pad has frames, each with the nearest of the others.
//
// While a pad is waited for: heads before `current` are discarded (kept), as step B would do later.
// Step A: current = max(current, times of all heads). End as soon as one pad has ended and is
// empty. Step B, each pad:
//   1. head < current: discarded (kept); no output; the round goes on with the same `current`.
//   2. kept is nearer to current than the head: kept is used, the head stays.
//   3. else the head is popped, kept and used.
// A gap counts as a head that is at gap_end or later: it never changes what is paired, only when
// that is known. A missing pad repeats its kept frame; without one the other heads are discarded.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/sync/policy.hpp"

namespace weir::sync {
Decision decide_slowest(const Round& round, std::span<const PadView> pads);
}  // namespace weir::sync
