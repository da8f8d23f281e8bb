// nosync: combines the n-th frames of all pads, whatever their times.
//
// Step A: current = max(current, times of all heads). Ends as soon as one pad has ended and is
// empty. Step B: pops and uses each head. Gaps have no effect, because times have none. A missing
// pad repeats its last frame; if it never had one, the other heads are discarded.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/sync/policy.hpp"

namespace weir::sync {
Decision decide_no_sync(const Round& round, std::span<const PadView> pads);
}  // namespace weir::sync
