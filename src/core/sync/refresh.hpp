// refresh: one output for each frame of any pad, with the last frames of the others.
//
// Runs for every head once each pad has had a frame. A pad that never had one is waited for unless
// it has a gap, is missing or has ended. Step A: current = max(current, times of the heads). Ends
// when all pads have ended and are empty. Step B: heads are popped and kept; other pads use their
// kept frame. No output while a pad never had a frame: the heads are discarded (kept).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/sync/policy.hpp"

namespace weir::sync {
Decision decide_refresh(const Round& round, std::span<const PadView> pads);
}  // namespace weir::sync
