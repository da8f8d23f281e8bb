// lateness: heads that are close in time go together; tensor_crop (docs/compatibility/routing.md
// 6.9).
//
// With a limit, a head that is older than another head by more than the limit is discarded.
// Otherwise all heads are popped and used, with the time and the metadata of pad 0. Ends as soon as
// one pad has ended and is empty. A gap discards heads that will be too old for the frame after the
// gap.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/sync/policy.hpp"

namespace weir::sync {
Decision decide_lateness(const Round& round, std::span<const PadView> pads, Stamp limit);
}  // namespace weir::sync
