// The lateness policy as a pure function.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/sync/lateness.hpp"

#include <algorithm>
#include <utility>

#include "core/sync/steps.hpp"

namespace weir::sync {
namespace {

// No head may be more than `limit` before this: the newest head, or the end of a gap.
Time newest_time(std::span<const PadView> pads, Stamp limit) {
  Time newest = 0;
  for (const PadView& pad : pads) {
    if (pad.state == PadState::Gap) newest = std::max(newest, pad.gap_end);
    if (pad.state == PadState::Head && limit) newest = std::max(newest, pad.head.value_or(0));
  }
  return newest;
}

}  // namespace

Decision decide_lateness(const Round& round, std::span<const PadView> pads, Stamp limit) {
  switch (readiness_of_all(round, pads)) {
    case Readiness::Over:
      return end_of_stream(round, pads.size());
    case Readiness::NotYet:
      return wait_for_more(round, pads.size());
    case Readiness::Ready:
      break;
  }
  const Time newest = newest_time(pads, limit);
  bool complete = true;
  std::vector<Use> uses(pads.size(), Use::Head);
  for (size_t i = 0; i < pads.size(); ++i) {
    const PadState state = pads[i].state;
    // A pad ends within a round only where that was begun by another policy; it has a kept frame.
    if (state == PadState::Ended) uses[i] = Use::Kept;
    complete = complete && (state == PadState::Head || state == PadState::Ended);
  }
  Decision out = wait_for_more(round, pads.size());
  for (size_t i = 0; i < pads.size(); ++i) {
    if (pads[i].state != PadState::Head || !pads[i].head || *pads[i].head >= newest) continue;
    if (newest - *pads[i].head <= limit.value_or(0)) continue;
    out.uses[i] = Use::Discard;
    complete = false;
  }
  if (!complete) return out;
  Round set = round;
  set.current = (uses[0] == Use::Kept ? pads[0].kept : pads[0].head).value_or(0);
  set.deciding = 0;
  return emit(set, std::move(uses));
}

}  // namespace weir::sync
