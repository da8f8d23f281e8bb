// The input and output of a sync policy: plain values, without threads or frames.
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

}  // namespace weir::sync
