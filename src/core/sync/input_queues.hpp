// InputQueues: the head and the kept frame of each pad, and one step of a sync policy. No threads.
//
// Ledger: a frame is consumed when it is used for the first time, and dropped (policy) when it is
// replaced unused. The caller counts received().
// SPDX-License-Identifier: LGPL-2.1-or-later
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
using QueueId = uint64_t;

template <class Frame>
struct Emission {
  Time time = 0;
  size_t metadata_pad = 0;    // index into frames
  std::vector<Frame> frames;  // in pad order
  uint64_t used_first = 0;    // frames used for the first time; they count as consumed
};

template <class Frame>
struct Step {
  Outcome outcome = Outcome::Wait;
  bool changed = false;  // heads were taken
  Emission<Frame> emission;
};

template <class Frame>
class InputQueues {
 public:
  struct InputQueue {
    QueueId id = 0;
    std::optional<Frame> head, kept;
    Stamp head_time, kept_time;
    uint64_t head_bytes = 0, kept_bytes = 0;
    bool kept_was_used = false;
    bool ended = false, missing = false, active = true;
    bool may_wait = false;  // was allowed to wait; until pads or streams change
    std::optional<Time> gap_end;
    // State for times that went back, see restart(). `shift` is added to each timestamp.
    Stamp last, highest;
    uint32_t frames_below = 0;  // consecutive frames below the highest time
    Time shift = 0;
    Clock::time_point empty_since, arrived;
  };
  struct Counts {
    uint64_t backwards = 0;  // frames
    uint64_t missed = 0;     // pads that exceeded max-wait
  };

  explicit InputQueues(Ledger* ledger) : ledger_(ledger) {}

  // Precondition: `id` is higher than all earlier ones.
  void add(QueueId id) {
    InputQueue queue;
    queue.id = id;
    queue.empty_since = Clock::now();
    queues_.push_back(std::move(queue));
    pads_changed();
  }
  void remove(QueueId id) {
    if (InputQueue* queue = find(id)) clear(*queue, DropReason::Flush);
    std::erase_if(queues_, [id](const InputQueue& l) { return l.id == id; });
    pads_changed();
  }
  InputQueue* find(QueueId id) noexcept {
    const auto it =
        std::lower_bound(queues_.begin(), queues_.end(), id,
                         [](const InputQueue& l, QueueId wanted) { return l.id < wanted; });
    return it == queues_.end() || it->id != id ? nullptr : &*it;
  }
  const std::deque<InputQueue>& all() const noexcept { return queues_; }
  const Counts& counts() const noexcept { return counts_; }
  // The bytes of all heads and kept frames.
  uint64_t held_bytes() const noexcept { return held_bytes_; }

  // Precondition: the queue exists and has no head. Returns false if the frame was dropped for its
  // time.
  bool put(QueueId id, Frame frame, Stamp time, OnBackwardsTime backwards, uint64_t bytes = 0) {
    InputQueue& queue = *find(id);
    queue.missing = false;
    if (time) *time += queue.shift;
    if (time && queue.last && *time < *queue.last) {
      ++counts_.backwards;
      if (backwards == OnBackwardsTime::Drop) {
        ledger_->dropped(DropReason::Time);
        return false;
      }
    }
    if (time) {
      queue.frames_below = queue.highest && *time <= *queue.highest &&
                                   (queue.frames_below > 0 || *time < *queue.last)
                               ? queue.frames_below + 1
                               : 0;
      queue.last = time;
      queue.highest = std::max(queue.highest.value_or(0), *time);
    }
    queue.gap_end.reset();
    queue.head = std::move(frame);
    queue.head_bytes = bytes;
    held_bytes_ += bytes;
    queue.head_time = time;
    queue.arrived = Clock::now();
    return true;
  }
  void gap(QueueId id, Time end) {
    InputQueue* queue = find(id);
    if (!queue || queue->head) return;
    queue->missing = false;
    queue->gap_end = std::max(queue->gap_end.value_or(0), end + queue->shift);
  }
  void end(QueueId id) {
    if (InputQueue* queue = find(id)) queue->ended = true;
  }
  // After an end or a flush: frames may arrive again.
  void begin(QueueId id) {
    InputQueue* queue = find(id);
    if (!queue) return;
    forget_waits();
    queue->ended = queue->missing = false;
    queue->empty_since = Clock::now();
  }
  void drop_head(QueueId id, DropReason reason) {
    InputQueue* queue = find(id);
    if (!queue || !queue->head) return;
    forget_head(*queue);
    queue->empty_since = Clock::now();
    ledger_->dropped(reason);
  }
  // FLUSH_STOP of docs/compatibility/routing.md 6.1: forgets kept frames and times; heads stay.
  void forget(DropReason reason) {
    for (InputQueue& queue : queues_) {
      drop_kept(queue, reason);
      queue.gap_end.reset();
      forget_times(queue);
      queue.last = queue.highest = queue.head_time;
    }
    round_ = {};
  }
  void clear_all(DropReason reason) {
    for (InputQueue& queue : queues_) clear(queue, reason);
    round_ = {};
  }

  // Marks queues as missing, until something arrives, if both they and `since` (a head's arrival)
  // are older than `timeout`. Returns true if a queue was newly marked.
  bool mark_missing(Clock::time_point since, Clock::duration timeout, Clock::time_point now) {
    bool found = false;
    for (InputQueue& queue : queues_) {
      if (queue.head || queue.ended || queue.missing) continue;
      if (deadline_after(std::max(since, queue.empty_since), timeout) > now) continue;
      queue.missing = found = true;
      ++counts_.missed;
    }
    return found;
  }
  std::optional<Clock::time_point> next_deadline(Clock::time_point since,
                                                 Clock::duration timeout) const {
    std::optional<Clock::time_point> out;
    for (const InputQueue& queue : queues_) {
      if (queue.head || queue.ended || queue.missing) continue;
      const auto at = deadline_after(std::max(since, queue.empty_since), timeout);
      if (!out || at < *out) out = at;
    }
    return out;
  }

  // Queues whose gaps extend beyond the time of the head of `waiting` but that must still be waited
  // for: nosync pairs by number, and basepad takes the first frame of a pad at any time. Empty if
  // another queue is waited for as well, or if a later gap is enough for the policy.
  std::vector<QueueId> gap_only_queues(Mode mode, QueueId waiting) {
    std::vector<QueueId> out;
    const InputQueue* own = find(waiting);
    if (!own || !own->head || (mode != Mode::NoSync && mode != Mode::BasePad)) return out;
    for (const InputQueue& queue : queues_) {
      if (queue.head || queue.missing) continue;
      const bool by_gap =
          queue.gap_end && !queue.ended && *queue.gap_end > own->head_time.value_or(0);
      if (!by_gap || (mode == Mode::BasePad && queue.kept)) return {};
      out.push_back(queue.id);
    }
    return out;
  }

  // Applies one decision of the policy. OPTION_VALUE if the base pad does not exist.
  Result<Step<Frame>> step(const Options& options) {
    if (options.mode == Mode::BasePad && options.base.pad >= queues_.size() && !queues_.empty())
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
    if (decision.outcome == Outcome::Emit) out.emission.frames.reserve(queues_.size());
    uint64_t& used_first = out.emission.used_first;
    for (size_t i = 0; i < queues_.size(); ++i)
      used_first += apply(queues_[i], decision.uses[i], &out) ? 1 : 0;
    if (used_first > 0) ledger_->consumed(used_first);
    return out;
  }
  // True: no policy can proceed until an empty pad gets a frame, a gap or an end. False means
  // unknown.
  bool must_wait(Mode mode) const noexcept {
    bool waited_for = false;
    for (const InputQueue& queue : queues_) {
      const bool too_old = queue.head && queue.head_time && *queue.head_time < round_.current;
      if (queue.ended || queue.frames_below > 1 || too_old) return false;
      const bool repeats = mode == Mode::Refresh && queue.kept;
      waited_for = waited_for || (get_state(queue) == PadState::Empty && !repeats);
    }
    return waited_for && mode != Mode::Lateness;
  }

 private:
  void forget_waits() {
    for (InputQueue& queue : queues_) queue.may_wait = false;
  }
  void pads_changed() {
    forget_waits();
    round_.need_set = true;
    round_.deciding.reset();
    round_.counted.clear();
  }
  void look() {
    views_.clear();
    for (const InputQueue& queue : queues_) {
      PadView& view = views_.emplace_back();
      view.state = get_state(queue);
      view.head = queue.head_time;
      view.gap_end = queue.gap_end.value_or(0);
      view.has_kept = queue.kept.has_value();
      view.kept = queue.kept_time;
      view.went_back = queue.frames_below > 0;
    }
  }
  static PadState get_state(const InputQueue& queue) noexcept {
    if (queue.head) return PadState::Head;
    if (queue.ended) return PadState::Ended;
    if (queue.missing) return PadState::Missing;
    return queue.gap_end ? PadState::Gap : PadState::Empty;
  }

  // Returns true if a frame was used for the first time.
  bool apply(InputQueue& queue, Use use, Step<Frame>* out) {
    if (use == Use::Head || use == Use::Discard) {
      keep_head(queue);
      out->changed = true;
    }
    if (use != Use::Head && use != Use::Kept) return false;
    out->emission.frames.push_back(*queue.kept);
    return !std::exchange(queue.kept_was_used, true);
  }
  void forget_head(InputQueue& queue) noexcept {
    if (queue.head) held_bytes_ -= queue.head_bytes;
    queue.head.reset();
  }
  void keep_head(InputQueue& queue) {
    drop_kept(queue, DropReason::Policy);
    queue.kept = std::move(queue.head);
    queue.kept_bytes = queue.head_bytes;
    queue.kept_time = queue.head_time;
    queue.head.reset();
    queue.empty_since = Clock::now();
  }
  void drop_kept(InputQueue& queue, DropReason reason) {
    if (queue.kept && !queue.kept_was_used) ledger_->dropped(reason);
    if (queue.kept) held_bytes_ -= queue.kept_bytes;
    queue.kept.reset();
    queue.kept_time.reset();
    queue.kept_was_used = false;
  }
  void clear(InputQueue& queue, DropReason reason) {
    if (queue.head) ledger_->dropped(reason);
    forget_head(queue);
    drop_kept(queue, reason);
    queue.gap_end.reset();
    forget_times(queue);
  }
  static void forget_times(InputQueue& queue) {
    queue.last.reset();
    queue.highest.reset();
    queue.frames_below = 0;
    queue.shift = 0;
  }

  // A pad whose time went back for more than one frame has started again (a loop, joined files).
  // Where times decide, the other pads' frames from before that moment have no partner left. They
  // are discarded until those pads go back as well, and `current` starts again; or until those pads
  // are seen to continue, and then the times of the pad that went back are shifted to continue as
  // well. Returns true if heads were taken.
  bool restart(Mode mode) {
    if (std::none_of(queues_.begin(), queues_.end(), [](auto& l) { return l.frames_below > 1; }))
      return false;
    if (mode != Mode::Slowest && mode != Mode::BasePad) {
      const bool all = std::all_of(queues_.begin(), queues_.end(),
                                   [](auto& l) { return l.frames_below > 0 || l.ended; });
      if (all) begin_again(false);
      return false;
    }
    Time horizon = 0;
    for (const InputQueue& queue : queues_)
      if (queue.frames_below > 1) horizon = std::max(horizon, *queue.highest);
    bool taken = false, settled = true, alone = false;
    for (InputQueue& queue : queues_) {
      if (queue.frames_below > 0 || queue.ended) continue;
      const bool from_before = queue.head && !is_past(queue, horizon);
      settled = settled && !from_before && get_state(queue) != PadState::Empty;
      alone = true;
      if (!from_before) continue;
      keep_head(queue);
      taken = true;
    }
    if (!settled) return taken;
    for (InputQueue& queue : queues_) {
      if (!alone || queue.frames_below == 0 || !queue.head || !queue.head_time) continue;
      queue.shift += horizon - *queue.head_time;
      queue.head_time = horizon;
    }
    begin_again(true);
    return false;
  }
  // A single frame may be past it by chance, because pads have their frames at different times.
  static bool is_past(const InputQueue& queue, Time horizon) {
    if (!queue.head_time) return true;
    return *queue.head_time > horizon && (!queue.kept_time || *queue.kept_time > horizon);
  }
  void begin_again(bool forget_kept) {
    round_ = {};
    for (InputQueue& queue : queues_) {
      queue.last = queue.highest = queue.head ? queue.head_time : queue.kept_time;
      if (forget_kept && queue.frames_below > 0) drop_kept(queue, DropReason::Policy);
      queue.frames_below = 0;
    }
  }

  Error no_base(size_t pad) const {
    return Error{.code = Code::OPTION_VALUE,
                 .what = "sync-option names a pad that does not exist",
                 .offered = "pad " + std::to_string(pad) + " of " + std::to_string(queues_.size()),
                 .needed = "a number below " + std::to_string(queues_.size()),
                 .fix = "sync-option=0"};
  }

  Ledger* ledger_;
  std::deque<InputQueue> queues_;  // in ascending order of id
  std::vector<PadView> views_;     // scratch of step(), reuses its memory
  uint64_t held_bytes_ = 0;
  Round round_;
  Counts counts_;
};

}  // namespace weir::sync
