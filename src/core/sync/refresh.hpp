// refresh: one output for each frame of any pad, with the last frame of the others.
//
// Runs for every head that comes, once each pad has had one (a pad that was never fed is waited
// for, unless it has a gap, is missing or has ended).
// Step A: current = max(current, times of the heads). End when all pads have ended and are empty.
// Step B: heads are popped and kept; other pads use the kept frame. No output while a pad never had
// SPDX-License-Identifier: LGPL-2.1-or-later
// a frame: the heads are discarded (kept).
#pragma once
#include "core/sync/policy.hpp"

namespace weir::sync {
Decision decide_refresh(const Round& round, std::span<const PadView> pads);
}  // namespace weir::sync
