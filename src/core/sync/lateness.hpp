// lateness: heads that are not too far apart go together; tensor_crop, specification 6.9.
//
// With a limit: a head that is older than another by more than it is discarded. Else, and without a
// limit, all heads are popped and used, at the time and with the metadata of pad 0. End as soon as
// one pad has ended and is empty. A gap discards the heads that would be too old for what ends it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/sync/policy.hpp"

namespace weir::sync {
Decision decide_lateness(const Round& round, std::span<const PadView> pads, Stamp limit);
}  // namespace weir::sync
