// What a sync policy sees of each pad and what it decides: plain values, no threads, no frames.
//
// The rules are those of the specification, 6.1. A round is made when every pad is known about:
//   Step A  only when need_set: `current`, the time of the next output, is found from the heads.
//   Step B  each pad's frame for that time is found: its head, or the frame kept before.
// A round is all or nothing: while one pad's head is too old for `current` (it is discarded, that
// is kept), no other pad is changed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace weir::sync {

using Time = uint64_t;  // nanoseconds
// Of a frame; nullopt = it has no time-stamp, and then fits every time.
using Stamp = std::optional<Time>;

enum class PadState {
  Empty,    // a head may still come: wait for it
  Head,     // has a frame
  Gap,      // no frame before `gap_end` will come
  Missing,  // was waited for long enough: goes on without it
  Ended,    // no frame will come any more
};

struct PadView {
  PadState state = PadState::Empty;
  Stamp head;        // of Head
  Time gap_end = 0;  // of Gap
  bool has_kept = false;
  Stamp kept;
  bool went_back = false;  // its times: what seems too old may begin a new stream
};

// What lasts from one collection to the next.
struct Round {
  Time current = 0;
  bool need_set = true;
  std::optional<size_t> deciding;  // the pad whose head determined `current`
  std::vector<bool> counted;       // the pads that step A has done, while gaps hold it up
  bool operator==(const Round&) const = default;
};

enum class Use {
  Nothing,  // is left as it is
  Head,     // is popped, used and kept
  Kept,     // the kept frame is used again, a head stays
  Discard,  // is popped and kept, and not used in this round
};
enum class Outcome { Wait, Emit, End };

struct Decision {
  Outcome outcome = Outcome::Wait;
  Round round;              // replaces the old one
  std::vector<Use> uses;    // one for each pad
  size_t metadata_pad = 0;  // of Emit: gives flags, duration, metas
};

inline Time distance(Time a, Time b) noexcept {
  return a > b ? a - b : b - a;
}

}  // namespace weir::sync
