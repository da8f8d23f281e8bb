// The basepad policy as a pure function.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/sync/base_pad.hpp"

#include <algorithm>

#include "core/sync/steps.hpp"

namespace weir::sync {
namespace {

// The window W of step B.
Time window_of(const PadView& base, Time duration) {
  if (!base.head || !base.has_kept || !base.kept) return 0;
  const Time apart = distance(*base.head, *base.kept);
  return apart == 0 ? 0 : std::min(duration, apart - 1);
}

// Nothing = not known yet.
Use step_b(const PadView& pad, Time current, Time window) {
  if (pad.state == PadState::Missing || pad.state == PadState::Ended) return Use::Kept;
  if (pad.state == PadState::Gap) {
    const bool too_far = pad.gap_end > current && pad.gap_end - current > window;
    return pad.has_kept && too_far ? Use::Kept : Use::Nothing;
  }
  if (!pad.head) return Use::Head;
  if (*pad.head < current) return Use::Discard;
  return pad.has_kept && *pad.head - current > window ? Use::Kept : Use::Head;
}

// No base frame can be before the end of its gap, so earlier heads will be too old. They are
// discarded, and their pads count as done in this round.
Decision base_has_a_gap(const Round& round, std::span<const PadView> pads, Time gap_end) {
  Decision out = wait_for_more(round, pads.size());
  out.round.counted.resize(pads.size(), false);
  for (size_t i = 0; i < pads.size(); ++i) {
    if (pads[i].state != PadState::Head || !pads[i].head || *pads[i].head >= gap_end) continue;
    out.uses[i] = Use::Discard;
    out.round.counted[i] = true;
  }
  return out;
}

Round step_a(const Round& round, const PadView& base, size_t index) {
  Round out = round;
  if (base.head) out.current = *base.head;
  out.deciding = index;
  out.need_set = false;
  out.counted.clear();
  return out;
}

bool never_fed_and_missing(const PadView& pad) {
  return pad.state == PadState::Missing && !pad.has_kept;
}

}  // namespace

Decision decide_base_pad(const Round& round, std::span<const PadView> pads, size_t base,
                         Time duration) {
  switch (readiness_of_all(round, pads)) {
    case Readiness::Over:
      return end_of_stream(round, pads.size());
    case Readiness::NotYet:
      return wait_for_more(round, pads.size());
    case Readiness::Ready:
      break;
  }
  if (pads[base].state == PadState::Missing ||
      std::any_of(pads.begin(), pads.end(), never_fed_and_missing))
    return discard_heads(round, pads);
  if (pads[base].state == PadState::Gap) return base_has_a_gap(round, pads, pads[base].gap_end);
  const Round set = round.need_set ? step_a(round, pads[base], base) : round;
  const Time window = window_of(pads[base], duration);
  std::vector<Use> uses;
  for (const PadView& pad : pads) uses.push_back(step_b(pad, set.current, window));
  const bool late = std::count(uses.begin(), uses.end(), Use::Discard) > 0;
  const bool unknown = std::count(uses.begin(), uses.end(), Use::Nothing) > 0;
  if (!late && !unknown) return emit(set, std::move(uses));
  Decision out = wait_for_more(set, pads.size());
  for (size_t i = 0; i < uses.size(); ++i)
    if (uses[i] == Use::Discard) out.uses[i] = Use::Discard;
  return out;
}

}  // namespace weir::sync
