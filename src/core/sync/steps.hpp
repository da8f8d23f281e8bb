// Steps that several policies share.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/sync/policy.hpp"

namespace weir::sync {

// A decision that changes nothing.
Decision wait_for_more(const Round& round, size_t pads);
// A decision that ends the stream.
Decision end_of_stream(const Round& round, size_t pads);
// Discards every head; the round begins anew.
Decision discard_heads(const Round& round, std::span<const PadView> pads);
// Step A of nosync, slowest and refresh. The first pad whose head has the highest time decides;
// none does when all are below `current`.
Round raised_to_heads(Round round, std::span<const PadView> pads);
// Completes an output: next time `current` is found anew.
Decision emit(const Round& round, std::vector<Use> uses);

enum class Readiness { Ready, NotYet, Over };
// Whether each pad has a head, a gap or is missing, and one of them a head (Ready); or is waited
// for (NotYet): what repeats kept frames alone would never end; or has ended (Over, which goes
// first). A pad that ends while the round is repeated counts as missing when it has a kept frame.
Readiness readiness_of_all(const Round& round, std::span<const PadView> pads);

}  // namespace weir::sync
