// The sync policies as pure functions of plain values, without threads or frames.
//
// The rules are in docs/compatibility/routing.md 6.1. A round starts when the state of every pad is
// known:
//   Step A  only if need_set: computes `current`, the time of the next output, from the heads.
//   Step B  selects each pad's frame for that time: its head, or the frame kept before.
// A round is all or nothing: while one pad's head is too old for `current` and is discarded (kept),
// no other pad changes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace weir::sync {

using Time = uint64_t;  // nanoseconds
// The time of a frame; nullopt = it has no timestamp and fits every time.
using Stamp = std::optional<Time>;

enum class PadState {
  Empty,    // a head may still arrive: wait for it
  Head,     // has a frame
  Gap,      // no frame before `gap_end` will arrive
  Missing,  // exceeded max-wait: outputs continue without it
  Ended,    // no more frames will arrive
};

struct PadView {
  PadState state = PadState::Empty;
  Stamp head;        // if state is Head
  Time gap_end = 0;  // if state is Gap
  bool has_kept = false;
  Stamp kept;
  bool went_back = false;  // its times went back: a head that seems too old may start a new stream
};

// The state that persists between decisions.
struct Round {
  Time current = 0;
  bool need_set = true;
  std::optional<size_t> deciding;  // the pad whose head determined `current`
  std::vector<bool> counted;       // the pads that step A has handled while gaps delay it
  bool operator==(const Round&) const = default;
};

enum class Use {
  Nothing,  // nothing changes
  Head,     // the head is popped, used and kept
  Kept,     // the kept frame is used again; a head stays
  Discard,  // the head is popped and kept, but not used in this round
};
enum class Outcome { Wait, Emit, End };

struct Decision {
  Outcome outcome = Outcome::Wait;
  Round round;              // replaces the previous one
  std::vector<Use> uses;    // one for each pad
  size_t metadata_pad = 0;  // for Emit: provides flags, duration and metas
};

inline Time distance(Time a, Time b) noexcept {
  return a > b ? a - b : b - a;
}

// nosync: combines the n-th frames of all pads, whatever their times.
//
// Step A: current = max(current, times of all heads). Ends as soon as one pad has ended and is
// empty. Step B: pops and uses each head. Gaps have no effect, because times have none. A missing
// pad repeats its last frame; if it never had one, the other heads are discarded.
Decision decide_no_sync(const Round& round, std::span<const PadView> pads);

// slowest: as many outputs as the slowest pad has frames, each with the nearest frames of the
// others.
//
// While a pad is waited for, heads before `current` are discarded (kept), as step B would do later.
// Step A: current = max(current, times of all heads). Ends as soon as one pad has ended and is
// empty. Step B, for each pad:
//   1. head < current: discards (keeps) it; no output; the round repeats with the same `current`.
//   2. the kept frame is nearer to current than the head: uses the kept frame; the head stays.
//   3. else pops, keeps and uses the head.
// A gap counts as a head at gap_end or later: it changes when pairs are known, never which ones. A
// missing pad repeats its kept frame; without one the other heads are discarded.
Decision decide_slowest(const Round& round, std::span<const PadView> pads);

// basepad: one output for each frame of one pad, the base.
//
// Step A: current = time of the base's head. Ends as soon as one pad has ended and is empty.
// Step B, for each pad, with window W = min(duration, |base head - base kept| - 1), at least 0, and
// 0 if either is missing:
//   1. head < current: discards (keeps) it; no output; the round repeats with the same `current`.
//   2. there is a kept frame and |current - head| > W: uses the kept frame; the head stays.
//   3. else pops, keeps and uses the head.
// A gap counts as a head at gap_end or later. A gap of the base discards the heads before its end.
// A missing pad repeats its kept frame; without one, or if the base is missing, the other heads are
// discarded.

inline constexpr Time kBaseDuration = 2147483647;  // nanoseconds; practically unlimited

// Precondition: base < pads.size().
Decision decide_base_pad(const Round& round, std::span<const PadView> pads, size_t base,
                         Time duration);

// refresh: one output for each frame of any pad, with the last frames of the others.
//
// Runs for every head once each pad has had a frame. A pad that never had one is waited for unless
// it has a gap, is missing or has ended. Step A: current = max(current, times of the heads). Ends
// when all pads have ended and are empty. Step B: heads are popped and kept; other pads use their
// kept frame. No output while a pad never had a frame: the heads are discarded (kept).
Decision decide_refresh(const Round& round, std::span<const PadView> pads);

// lateness: heads that are close in time go together; tensor_crop (docs/compatibility/routing.md
// 6.9).
//
// With a limit, a head that is older than another head by more than the limit is discarded.
// Otherwise all heads are popped and used, with the time and the metadata of pad 0. Ends as soon as
// one pad has ended and is empty. A gap discards heads that will be too old for the frame after the
// gap.
Decision decide_lateness(const Round& round, std::span<const PadView> pads, Stamp limit);

}  // namespace weir::sync
