// Implements the shared steps of the policies.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/sync/steps.hpp"

#include <algorithm>

namespace weir::sync {

Decision wait_for_more(const Round& round, size_t pads) {
  return {Outcome::Wait, round, std::vector<Use>(pads, Use::Nothing), 0};
}

Decision end_of_stream(const Round& round, size_t pads) {
  return {Outcome::End, round, std::vector<Use>(pads, Use::Nothing), 0};
}

Decision discard_heads(const Round& round, std::span<const PadView> pads) {
  Decision out = wait_for_more(round, pads.size());
  out.round.need_set = true;  // the round that a gap delayed has no heads any more
  out.round.deciding.reset();
  out.round.counted.clear();
  for (size_t i = 0; i < pads.size(); ++i)
    if (pads[i].state == PadState::Head) out.uses[i] = Use::Discard;
  return out;
}

Round raised_to_heads(Round round, std::span<const PadView> pads) {
  round.deciding.reset();
  for (size_t i = 0; i < pads.size(); ++i) {
    const PadView& pad = pads[i];
    if (pad.state != PadState::Head || !pad.head) continue;
    if (*pad.head < round.current || (*pad.head == round.current && round.deciding)) continue;
    round.current = *pad.head;
    round.deciding = i;
  }
  return round;
}

Decision emit(const Round& round, std::vector<Use> uses) {
  Decision out{Outcome::Emit, round, std::move(uses), 0};
  const auto fresh = std::find(out.uses.begin(), out.uses.end(), Use::Head);
  const size_t first = fresh == out.uses.end() ? 0 : static_cast<size_t>(fresh - out.uses.begin());
  out.metadata_pad = round.deciding.value_or(first);
  out.round.need_set = true;
  return out;
}

Readiness readiness_of_all(const Round& round, std::span<const PadView> pads) {
  bool all = true, fresh = false, over = !pads.empty();
  for (size_t i = 0; i < pads.size(); ++i) {
    const PadView& pad = pads[i];
    const bool had_part = !round.need_set || (i < round.counted.size() && round.counted[i]);
    if (pad.state == PadState::Ended && !(had_part && pad.has_kept)) return Readiness::Over;
    over = over && pad.state == PadState::Ended;
    all = all && pad.state != PadState::Empty;
    fresh = fresh || pad.state == PadState::Head;
  }
  if (over) return Readiness::Over;
  return all && fresh ? Readiness::Ready : Readiness::NotYet;
}

}  // namespace weir::sync
