// Lanes: the head and the kept frame of each pad, with a policy applied to them. No threads.
//
// Ledger: a frame is consumed when it is used for the first time, and dropped (policy) when it
// leaves unused. received() is counted by the caller.
#pragma once
#include <algorithm>
#include <chrono>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/ledger/ledger.hpp"
#include "core/sync/backwards_time.hpp"
#include "core/sync/options.hpp"
#include "core/timer/deadline.hpp"

namespace weir::sync {

using Clock = std::chrono::steady_clock;
using LaneId = uint64_t;

template <class Frame>
struct Emission {
  Time time = 0;
  size_t metadata_pad = 0;    // index into frames
  std::vector<Frame> frames;  // in pad order
  uint64_t used_first = 0;    // of them, for the first time: they count as consumed
};

template <class Frame>
struct Step {
  Outcome outcome = Outcome::Wait;
  bool changed = false;  // heads were taken
  Emission<Frame> emission;
};

template <class Frame>
class Lanes {
 public:
  struct Lane {
    LaneId id = 0;
    std::optional<Frame> head, kept;
    Stamp head_time, kept_time;
    uint64_t head_bytes = 0, kept_bytes = 0;
    bool kept_was_used = false;
    bool ended = false, missing = false, active = true;
    bool may_wait = false;  // was asked; until pads or streams change
    std::optional<Time> gap_end;
    // Times that went back, see restart(). `shift` is added to each time-stamp.
    Stamp last, highest;
    uint32_t frames_below = 0;  // in a row, that came behind a higher one
    Time shift = 0;
    Clock::time_point empty_since, arrived;
  };
  struct Counts {
    uint64_t backwards = 0;  // frames
    uint64_t missed = 0;     // pads that were not waited for any longer
  };

  explicit Lanes(Ledger* ledger) : ledger_(ledger) {}

  // Precondition: `id` is higher than all before.
  void add(LaneId id) {
    Lane lane;
    lane.id = id;
    lane.empty_since = Clock::now();
    lanes_.push_back(std::move(lane));
    pads_changed();
  }
  void remove(LaneId id) {
    if (Lane* lane = find(id)) clear(*lane, DropReason::Flush);
    std::erase_if(lanes_, [id](const Lane& l) { return l.id == id; });
    pads_changed();
  }
  Lane* find(LaneId id) noexcept {
    const auto it = std::lower_bound(lanes_.begin(), lanes_.end(), id,
                                     [](const Lane& l, LaneId wanted) { return l.id < wanted; });
    return it == lanes_.end() || it->id != id ? nullptr : &*it;
  }
  const std::deque<Lane>& all() const noexcept { return lanes_; }
  const Counts& counts() const noexcept { return counts_; }
  // Of all heads and kept frames.
  uint64_t held_bytes() const noexcept { return held_bytes_; }

  // Precondition: the lane is there and has no head. False: dropped for its time.
  bool put(LaneId id, Frame frame, Stamp time, OnBackwardsTime backwards, uint64_t bytes = 0) {
    Lane& lane = *find(id);
    lane.missing = false;
    if (time) *time += lane.shift;
    if (time && lane.last && *time < *lane.last) {
      ++counts_.backwards;
      if (backwards == OnBackwardsTime::Drop) {
        ledger_->dropped(DropReason::Time);
        return false;
      }
    }
    if (time) {
      lane.frames_below =
          lane.highest && *time <= *lane.highest && (lane.frames_below > 0 || *time < *lane.last)
              ? lane.frames_below + 1
              : 0;
      lane.last = time;
      lane.highest = std::max(lane.highest.value_or(0), *time);
    }
    lane.gap_end.reset();
    lane.head = std::move(frame);
    lane.head_bytes = bytes;
    held_bytes_ += bytes;
    lane.head_time = time;
    lane.arrived = Clock::now();
    return true;
  }
  void gap(LaneId id, Time end) {
    Lane* lane = find(id);
    if (!lane || lane->head) return;
    lane->missing = false;
    lane->gap_end = std::max(lane->gap_end.value_or(0), end + lane->shift);
  }
  void end(LaneId id) {
    if (Lane* lane = find(id)) lane->ended = true;
  }
  // After an end, or a flush: frames may come again.
  void begin(LaneId id) {
    Lane* lane = find(id);
    if (!lane) return;
    forget_asked();
    lane->ended = lane->missing = false;
    lane->empty_since = Clock::now();
  }
  void drop_head(LaneId id, DropReason reason) {
    Lane* lane = find(id);
    if (!lane || !lane->head) return;
    forget_head(*lane);
    lane->empty_since = Clock::now();
    ledger_->dropped(reason);
  }
  // Specification 6.1, FLUSH_STOP: kept frames and times are forgotten; heads stay.
  void forget(DropReason reason) {
    for (Lane& lane : lanes_) {
      drop_kept(lane, reason);
      lane.gap_end.reset();
      forget_times(lane);
      lane.last = lane.highest = lane.head_time;
    }
    round_ = {};
  }
  void clear_all(DropReason reason) {
    for (Lane& lane : lanes_) clear(lane, reason);
    round_ = {};
  }

  // Lanes that were waited for since both they and `since` (a head's arrival) for `patience`: they
  // are missing from now on, until something comes. True when there is a new one.
  bool mark_missing(Clock::time_point since, Clock::duration patience, Clock::time_point now) {
    bool found = false;
    for (Lane& lane : lanes_) {
      if (lane.head || lane.ended || lane.missing) continue;
      if (deadline_after(std::max(since, lane.empty_since), patience) > now) continue;
      lane.missing = found = true;
      ++counts_.missed;
    }
    return found;
  }
  std::optional<Clock::time_point> next_deadline(Clock::time_point since,
                                                 Clock::duration patience) const {
    std::optional<Clock::time_point> out;
    for (const Lane& lane : lanes_) {
      if (lane.head || lane.ended || lane.missing) continue;
      const auto at = deadline_after(std::max(since, lane.empty_since), patience);
      if (!out || at < *out) out = at;
    }
    return out;
  }

  // Lanes whose gaps have passed the time of the head of `waiting`, and are waited for all the
  // same: nosync pairs by number, and basepad takes the first frame of a pad however late it is.
  // Empty where another lane is waited for too, or the policy needs no more than a later gap.
  std::vector<LaneId> waited_for_behind_gaps(Mode mode, LaneId waiting) {
    std::vector<LaneId> out;
    const Lane* own = find(waiting);
    if (!own || !own->head || (mode != Mode::NoSync && mode != Mode::BasePad)) return out;
    for (const Lane& lane : lanes_) {
      if (lane.head || lane.missing) continue;
      const bool by_gap = lane.gap_end && !lane.ended && *lane.gap_end > own->head_time.value_or(0);
      if (!by_gap || (mode == Mode::BasePad && lane.kept)) return {};
      out.push_back(lane.id);
    }
    return out;
  }

  // One decision of the policy, applied. OPTION_VALUE when the base pad is not there.
  Result<Step<Frame>> step(const Options& options) {
    if (options.mode == Mode::BasePad && options.base.pad >= lanes_.size() && !lanes_.empty())
      return no_base(options.base.pad);
    if (restart(options.mode)) return Step<Frame>{Outcome::Wait, true, {}};
    if (must_wait(options.mode)) return Step<Frame>{};
    look();
    Decision decision = decide(options, round_, views_);
    round_ = std::move(decision.round);
    if (decision.outcome == Outcome::End) {
      clear_all(DropReason::Eos);
      return Step<Frame>{Outcome::End, true, {}};
    }
    Step<Frame> out{decision.outcome, false, {round_.current, decision.metadata_pad, {}, 0}};
    if (decision.outcome == Outcome::Emit) out.emission.frames.reserve(lanes_.size());
    uint64_t& used_first = out.emission.used_first;
    for (size_t i = 0; i < lanes_.size(); ++i)
      used_first += apply(lanes_[i], decision.uses[i], &out) ? 1 : 0;
    if (used_first > 0) ledger_->consumed(used_first);
    return out;
  }
  // True: no policy has anything to do before a pad that is empty gets a frame, a gap or an end.
  // False says nothing.
  bool must_wait(Mode mode) const noexcept {
    bool waited_for = false;
    for (const Lane& lane : lanes_) {
      const bool too_old = lane.head && lane.head_time && *lane.head_time < round_.current;
      if (lane.ended || lane.frames_below > 1 || too_old) return false;
      const bool repeats = mode == Mode::Refresh && lane.kept;
      waited_for = waited_for || (state_of(lane) == PadState::Empty && !repeats);
    }
    return waited_for && mode != Mode::Lateness;
  }

 private:
  void forget_asked() {
    for (Lane& lane : lanes_) lane.may_wait = false;
  }
  void pads_changed() {
    forget_asked();
    round_.need_set = true;
    round_.deciding.reset();
    round_.counted.clear();
  }
  void look() {
    views_.clear();
    for (const Lane& lane : lanes_) {
      PadView& view = views_.emplace_back();
      view.state = state_of(lane);
      view.head = lane.head_time;
      view.gap_end = lane.gap_end.value_or(0);
      view.has_kept = lane.kept.has_value();
      view.kept = lane.kept_time;
      view.went_back = lane.frames_below > 0;
    }
  }
  static PadState state_of(const Lane& lane) noexcept {
    if (lane.head) return PadState::Head;
    if (lane.ended) return PadState::Ended;
    if (lane.missing) return PadState::Missing;
    return lane.gap_end ? PadState::Gap : PadState::Empty;
  }

  // True: a frame was used for the first time.
  bool apply(Lane& lane, Use use, Step<Frame>* out) {
    if (use == Use::Head || use == Use::Discard) {
      keep_head(lane);
      out->changed = true;
    }
    if (use != Use::Head && use != Use::Kept) return false;
    out->emission.frames.push_back(*lane.kept);
    return !std::exchange(lane.kept_was_used, true);
  }
  void forget_head(Lane& lane) noexcept {
    if (lane.head) held_bytes_ -= lane.head_bytes;
    lane.head.reset();
  }
  void keep_head(Lane& lane) {
    drop_kept(lane, DropReason::Policy);
    lane.kept = std::move(lane.head);
    lane.kept_bytes = lane.head_bytes;
    lane.kept_time = lane.head_time;
    lane.head.reset();
    lane.empty_since = Clock::now();
  }
  void drop_kept(Lane& lane, DropReason reason) {
    if (lane.kept && !lane.kept_was_used) ledger_->dropped(reason);
    if (lane.kept) held_bytes_ -= lane.kept_bytes;
    lane.kept.reset();
    lane.kept_time.reset();
    lane.kept_was_used = false;
  }
  void clear(Lane& lane, DropReason reason) {
    if (lane.head) ledger_->dropped(reason);
    forget_head(lane);
    drop_kept(lane, reason);
    lane.gap_end.reset();
    forget_times(lane);
  }
  static void forget_times(Lane& lane) {
    lane.last.reset();
    lane.highest.reset();
    lane.frames_below = 0;
    lane.shift = 0;
  }

  // A pad whose time went back for more than one frame has begun anew (a loop, joined files).
  // Where times decide, the frames of the other pads from before that moment have no partner any
  // more: they are discarded until those pads go back too, and `current` starts again; or until
  // they are seen to go on, and then the times of the pad that went back go on where they were.
  // True: heads were taken.
  bool restart(Mode mode) {
    if (std::none_of(lanes_.begin(), lanes_.end(), [](auto& l) { return l.frames_below > 1; }))
      return false;
    if (mode != Mode::Slowest && mode != Mode::BasePad) {
      const bool all = std::all_of(lanes_.begin(), lanes_.end(),
                                   [](auto& l) { return l.frames_below > 0 || l.ended; });
      if (all) begin_anew(false);
      return false;
    }
    Time horizon = 0;
    for (const Lane& lane : lanes_)
      if (lane.frames_below > 1) horizon = std::max(horizon, *lane.highest);
    bool taken = false, settled = true, alone = false;
    for (Lane& lane : lanes_) {
      if (lane.frames_below > 0 || lane.ended) continue;
      const bool from_before = lane.head && !is_past(lane, horizon);
      settled = settled && !from_before && state_of(lane) != PadState::Empty;
      alone = true;
      if (!from_before) continue;
      keep_head(lane);
      taken = true;
    }
    if (!settled) return taken;
    for (Lane& lane : lanes_) {
      if (!alone || lane.frames_below == 0 || !lane.head || !lane.head_time) continue;
      lane.shift += horizon - *lane.head_time;
      lane.head_time = horizon;
    }
    begin_anew(true);
    return false;
  }
  // One frame may be past it by chance: pads do not have their frames at the same times.
  static bool is_past(const Lane& lane, Time horizon) {
    if (!lane.head_time) return true;
    return *lane.head_time > horizon && (!lane.kept_time || *lane.kept_time > horizon);
  }
  void begin_anew(bool forget_kept) {
    round_ = {};
    for (Lane& lane : lanes_) {
      lane.last = lane.highest = lane.head ? lane.head_time : lane.kept_time;
      if (forget_kept && lane.frames_below > 0) drop_kept(lane, DropReason::Policy);
      lane.frames_below = 0;
    }
  }

  Error no_base(size_t pad) const {
    return Error{Code::OPTION_VALUE,
                 "sync-option names a pad that is not there",
                 "pad " + std::to_string(pad) + " of " + std::to_string(lanes_.size()),
                 "a number below " + std::to_string(lanes_.size()),
                 "",
                 "sync-option=0"};
  }

  Ledger* ledger_;
  std::deque<Lane> lanes_;      // by ascending id
  std::vector<PadView> views_;  // of step(), kept for its memory
  uint64_t held_bytes_ = 0;
  Round round_;
  Counts counts_;
};

}  // namespace weir::sync
