// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/sync/policies.hpp"

#include <algorithm>
#include <utility>

namespace weir::sync {
namespace {

enum class Readiness { Ready, NotYet, Over };

// A decision that changes nothing.
Decision wait_for_more(const Round& round, size_t pads) {
  return {Outcome::Wait, round, std::vector<Use>(pads, Use::Nothing), 0};
}

// A decision that ends the stream.
Decision end_of_stream(const Round& round, size_t pads) {
  return {Outcome::End, round, std::vector<Use>(pads, Use::Nothing), 0};
}

// Discards every head and starts the round again.
Decision discard_heads(const Round& round, std::span<const PadView> pads) {
  Decision out = wait_for_more(round, pads.size());
  out.round.need_set = true;  // the round that a gap delayed has no heads any more
  out.round.deciding.reset();
  out.round.counted.clear();
  for (size_t i = 0; i < pads.size(); ++i)
    if (pads[i].state == PadState::Head) out.uses[i] = Use::Discard;
  return out;
}

// Step A of nosync, slowest and refresh. The first pad whose head has the highest time decides;
// none does if all are below `current`.
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

// Completes an output; the next round computes `current` again.
Decision emit(const Round& round, std::vector<Use> uses) {
  Decision out{Outcome::Emit, round, std::move(uses), 0};
  const auto fresh = std::find(out.uses.begin(), out.uses.end(), Use::Head);
  const size_t first = fresh == out.uses.end() ? 0 : static_cast<size_t>(fresh - out.uses.begin());
  out.metadata_pad = round.deciding.value_or(first);
  out.round.need_set = true;
  return out;
}

// Ready: each pad has a head or a gap or is missing, and at least one has a head (repeating only
// kept frames would never end). NotYet: a pad is waited for. Over, which has priority: a pad has
// ended. A pad that ends while the round is repeated counts as missing if it has a kept frame.
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

// The window W of step B.
Time make_window(const PadView& base, Time duration) {
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
  const Time window = make_window(pads[base], duration);
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
