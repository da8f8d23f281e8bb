// nosync: the n-th frame of each pad together, whatever their times.
//
// Step A: current = max(current, times of all heads). End as soon as one pad has ended and is
// empty. Step B: each head is popped and used. Gaps mean nothing here, since times do not. A
// missing pad repeats its last frame; when it never had one, the other heads are discarded.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/sync/policy.hpp"

namespace weir::sync {
Decision decide_no_sync(const Round& round, std::span<const PadView> pads);
}  // namespace weir::sync
