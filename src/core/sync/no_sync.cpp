// The nosync policy as a pure function.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/sync/no_sync.hpp"

#include "core/sync/steps.hpp"

namespace weir::sync {

Decision decide_no_sync(const Round& round, std::span<const PadView> pads) {
  switch (readiness_of_all(round, pads)) {
    case Readiness::Over:
      return end_of_stream(round, pads.size());
    case Readiness::NotYet:
      return wait_for_more(round, pads.size());
    case Readiness::Ready:
      break;
  }
  std::vector<Use> uses(pads.size(), Use::Head);
  for (size_t i = 0; i < pads.size(); ++i) {
    if (pads[i].state == PadState::Gap) return wait_for_more(round, pads.size());
    // A pad can end within a round only if another policy started the round.
    if (pads[i].state != PadState::Missing && pads[i].state != PadState::Ended) continue;
    if (!pads[i].has_kept) return discard_heads(round, pads);
    uses[i] = Use::Kept;
  }
  return emit(raised_to_heads(round, pads), std::move(uses));
}

}  // namespace weir::sync
