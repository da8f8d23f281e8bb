// Steps that several sync policies share.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/sync/policy.hpp"

namespace weir::sync {

// A decision that changes nothing.
Decision wait_for_more(const Round& round, size_t pads);
// A decision that ends the stream.
Decision end_of_stream(const Round& round, size_t pads);
// Discards every head and starts the round again.
Decision discard_heads(const Round& round, std::span<const PadView> pads);
// Step A of nosync, slowest and refresh. The first pad whose head has the highest time decides;
// none does if all are below `current`.
Round raised_to_heads(Round round, std::span<const PadView> pads);
// Completes an output; the next round computes `current` again.
Decision emit(const Round& round, std::vector<Use> uses);

enum class Readiness { Ready, NotYet, Over };
// Ready: each pad has a head or a gap or is missing, and at least one has a head (repeating only
// kept frames would never end). NotYet: a pad is waited for. Over, which has priority: a pad has
// ended. A pad that ends while the round is repeated counts as missing if it has a kept frame.
Readiness readiness_of_all(const Round& round, std::span<const PadView> pads);

}  // namespace weir::sync
