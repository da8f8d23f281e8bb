// The slowest policy as a pure function.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/sync/slowest.hpp"

#include <algorithm>

#include "core/sync/steps.hpp"

namespace weir::sync {
namespace {

// The time that the next frame of the pad has, or is not before.
Stamp next_time(const PadView& pad) {
  if (pad.state == PadState::Gap) return pad.gap_end;
  return pad.state == PadState::Head ? pad.head : Stamp();
}

// Step A. The frame after a gap cannot be before the gap's end, and `current` not before that
// frame, so the other pads can advance to the end of the gap. The step completes when that frame is
// known.
Round step_a(const Round& round, std::span<const PadView> pads) {
  Round out = round;
  if (out.counted.empty()) out.deciding.reset();
  out.counted.resize(pads.size(), false);
  for (size_t i = 0; i < pads.size(); ++i) {
    const PadView& pad = pads[i];
    const bool gap = pad.state == PadState::Gap;
    if (out.counted[i]) continue;
    out.counted[i] = !gap;
    const Stamp time = next_time(pad);
    if (!time || *time < out.current || (*time == out.current && (gap || out.deciding))) continue;
    out.current = *time;
    out.deciding = gap ? std::optional<size_t>() : i;
  }
  out.need_set = std::count(out.counted.begin(), out.counted.end(), false) > 0;
  if (!out.need_set) out.counted.clear();
  return out;
}

bool kept_is_nearer(const PadView& pad, Time current, Time head) {
  return pad.has_kept && pad.kept && distance(current, *pad.kept) < distance(current, head);
}

// Nothing = not known yet.
Use step_b(const PadView& pad, Time current) {
  if (pad.state == PadState::Missing || pad.state == PadState::Ended) return Use::Kept;
  if (pad.state == PadState::Gap) {
    const bool later = pad.gap_end > current;
    return later && kept_is_nearer(pad, current, pad.gap_end) ? Use::Kept : Use::Nothing;
  }
  if (!pad.head) return Use::Head;
  if (*pad.head < current) return Use::Discard;
  return kept_is_nearer(pad, current, *pad.head) ? Use::Kept : Use::Head;
}

// A head before `current` has no partner, whatever the other pads deliver, and must not wait for
// them: a pad that starts late has a full queue of such frames, which blocks the tee that feeds all
// pads. Step A is done for such a pad: its next head arrives too late to raise `current` in this
// round.
Decision discard_what_is_too_old(const Round& round, std::span<const PadView> pads) {
  Decision out = wait_for_more(round, pads.size());
  for (size_t i = 0; i < pads.size(); ++i) {
    const PadView& pad = pads[i];
    if (pad.state != PadState::Head || !pad.head || *pad.head >= round.current || pad.went_back)
      continue;
    out.uses[i] = Use::Discard;
    if (!round.need_set) continue;
    if (out.round.counted.empty()) out.round.deciding.reset();
    out.round.counted.resize(pads.size(), false);
    out.round.counted[i] = true;
  }
  return out;
}

bool slowest_is_missing(const PadView& pad) {
  return pad.state == PadState::Missing && !pad.has_kept;
}

}  // namespace

Decision decide_slowest(const Round& round, std::span<const PadView> pads) {
  switch (readiness_of_all(round, pads)) {
    case Readiness::Over:
      return end_of_stream(round, pads.size());
    case Readiness::NotYet:
      return discard_what_is_too_old(round, pads);
    case Readiness::Ready:
      break;
  }
  if (std::any_of(pads.begin(), pads.end(), slowest_is_missing)) return discard_heads(round, pads);
  const Round set = round.need_set ? step_a(round, pads) : round;
  std::vector<Use> uses;
  for (const PadView& pad : pads) uses.push_back(step_b(pad, set.current));
  const bool late = std::count(uses.begin(), uses.end(), Use::Discard) > 0;
  const bool unknown = std::count(uses.begin(), uses.end(), Use::Nothing) > 0;
  if (!late && !unknown && !set.need_set) return emit(set, std::move(uses));
  Decision out = wait_for_more(set, pads.size());
  for (size_t i = 0; i < uses.size(); ++i)
    if (uses[i] == Use::Discard) out.uses[i] = Use::Discard;
  return out;
}

}  // namespace weir::sync
