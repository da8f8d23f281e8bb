// The refresh policy as a pure function.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/sync/refresh.hpp"

#include <algorithm>

#include "core/sync/steps.hpp"

namespace weir::sync {

Decision decide_refresh(const Round& round, std::span<const PadView> pads) {
  const auto all = [&pads](auto&& f) { return std::all_of(pads.begin(), pads.end(), f); };
  if (pads.empty()) return wait_for_more(round, 0);
  if (all([](const PadView& p) { return p.state == PadState::Ended; }))
    return end_of_stream(round, pads.size());
  const bool begun = all([](const PadView& p) { return p.state != PadState::Empty || p.has_kept; });
  const bool fed = !all([](const PadView& p) { return p.state != PadState::Head; });
  if (!begun || !fed) return wait_for_more(round, pads.size());
  const bool complete =
      all([](const PadView& p) { return p.state == PadState::Head || p.has_kept; });
  if (!complete) return discard_heads(round, pads);
  std::vector<Use> uses;
  for (const PadView& pad : pads)
    uses.push_back(pad.state == PadState::Head ? Use::Head : Use::Kept);
  return emit(raised_to_heads(round, pads), std::move(uses));
}

}  // namespace weir::sync
