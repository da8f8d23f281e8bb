// Collector: frames of many pads, brought by as many threads, become one stream by a policy.
//
// A frame is handled on the thread that brings it: offer() returns when the frame was taken as the
// policy says, and the thread whose frame completes an output makes that output. There is no other
// thread. Everything that waits here is woken by flush, end, removal of its pad, and stop.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "core/sync/lanes.hpp"

namespace weir::sync {

// What offer() returns: 0, or a negative number for which no further frame is wanted.
inline constexpr int kOk = 0, kNotLinked = -1, kFlushing = -2, kEnded = -3, kRefused = -5;

template <class Frame>
struct Consumer {
  virtual ~Consumer() = default;
  // One call at a time, never locked. Another result than kOk is given to every pad from then on,
  // but for kNotLinked, which holds for as long as it comes: links are made while frames flow.
  virtual int emit(Emission<Frame> emission) = 0;
  virtual void end() = 0;  // no emission follows, until a flush
  virtual void refused(const Error& error) = 0;
  // `waiting` is about to wait for `empty`. An error: they would wait for ever, it is refused.
  virtual Status may_wait(LaneId waiting, const std::vector<LaneId>& empty) = 0;
  // `waiting` has waited long for `gaps`, which have had gaps alone past its time, and waits on.
  // Told once from start to stop.
  virtual void waits_behind_gaps(LaneId waiting, const std::vector<LaneId>& gaps) = 0;
};

inline constexpr Clock::duration kGapPatience = std::chrono::seconds(1);

template <class Frame>
class Collector {
 public:
  Collector(Ledger* ledger, Consumer<Frame>* consumer, Clock::duration gap_patience = kGapPatience)
      : ledger_(ledger), consumer_(consumer), gap_patience_(gap_patience), lanes_(ledger) {}

  // `max_bytes` bounds the bytes of all frames that are held, 0 = any; one frame alone may be more.
  void configure(const Options& options, OnBackwardsTime backwards, Clock::duration max_wait,
                 uint64_t max_bytes = 0) {
    std::lock_guard lock(mutex_);
    max_bytes_ = max_bytes;
    options_ = options;
    backwards_ = backwards;
    max_wait_ = max_wait;
    tell();
  }
  void start() {
    std::unique_lock lock(mutex_);
    wait_for_runner(lock);  // proceed() may still push what belongs to the time before stop()
    lanes_.clear_all(DropReason::Flush);
    for (const auto& lane : lanes_.all()) lanes_.begin(lane.id);
    flow_ = kOk;
    most_bytes_ = 0;
    linked_ = started_ = true;
    told_of_gaps_ = false;
  }
  void stop() {
    std::lock_guard lock(mutex_);
    started_ = false;
    lanes_.clear_all(DropReason::Flush);
    flushing_.clear();
    output_flushes_ = false;
    tell();
  }

  LaneId add() {
    std::lock_guard lock(mutex_);
    lanes_.add(++last_id_);
    return last_id_;
  }
  // True where the output flushed for this lane alone, as flush_stop(). Makes no output: call
  // proceed() on a thread that may block, for what becomes possible without the lane.
  bool remove(LaneId id) {
    std::unique_lock lock(mutex_);
    lanes_.remove(id);
    std::erase(flushing_, id);
    tell();
    return end_flush(lock);
  }
  void proceed() {
    std::unique_lock lock(mutex_);
    work(lock);
  }

  // Takes a frame of the lane, and waits until the policy took it; one thread for each lane. Beyond
  // max_bytes it waits for what is being made, as long as that can make room; else the streams
  // need more than the bound: LIMIT_EXCEEDED.
  int offer(LaneId id, Frame frame, Stamp time, uint64_t bytes = 0) {
    std::unique_lock lock(mutex_);
    ledger_->received();
    const int refused = refusal(id);
    if (refused != kOk) {
      ledger_->dropped(reason_of(refused));
      return refused;
    }
    if (const int beyond = wait_for_bytes(lock, id, bytes); beyond != kOk) return beyond;
    if (!lanes_.put(id, std::move(frame), time, backwards_, bytes)) return kOk;
    most_bytes_ = std::max(most_bytes_, lanes_.held_bytes());
    return wait_until_taken(lock, id);
  }
  // No frame before `end` will come.
  void gap(LaneId id, Time end) {
    std::unique_lock lock(mutex_);
    const bool waited = a_head_waits_behind_gaps();
    lanes_.gap(id, end);
    work(lock);
    if (!waited && a_head_waits_behind_gaps()) tell();  // who waits counts the time from here
  }
  void end(LaneId id) {
    std::unique_lock lock(mutex_);
    lanes_.end(id);
    work(lock);
  }
  void begin(LaneId id) {
    std::lock_guard lock(mutex_);
    lanes_.begin(id);
  }

  // A lane that is not active takes nothing; who waits there is sent away.
  void set_active(LaneId id, bool active) {
    std::lock_guard lock(mutex_);
    auto* lane = lanes_.find(id);
    if (!lane) return;
    lane->active = active;
    if (!active) lanes_.drop_head(id, DropReason::Flush);
    tell();
  }

  // True for the first lane of all that flushes: then send FLUSH_START downstream and call
  // flush_sent().
  [[nodiscard]] bool flush_start(LaneId id) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !another_sends(); });
    if (!lanes_.find(id)) return false;  // it was removed meanwhile
    if (!is_flushing(id)) flushing_.push_back(id);
    lanes_.drop_head(id, DropReason::Flush);
    tell();
    if (output_flushes_) return false;
    flush_sender_ = std::this_thread::get_id();
    return output_flushes_ = true;
  }
  // True for the last lane: then send FLUSH_STOP downstream and call flush_sent(). Waits until what
  // is being emitted has left.
  [[nodiscard]] bool flush_stop(LaneId id) {
    std::unique_lock lock(mutex_);
    if (std::erase(flushing_, id) == 0) return false;
    lanes_.begin(id);
    return end_flush(lock);
  }
  // FLUSH_START and FLUSH_STOP go downstream in the order in which they were decided.
  void flush_sent() {
    std::lock_guard lock(mutex_);
    flush_sender_.reset();
    tell();
  }

  // Calls `use` while no output is made, for what a lane sends downstream besides frames. False: it
  // was not called, because the lane is not active, flushes or was removed.
  template <class Use>
  bool use_output(LaneId id, Use&& use) {
    std::unique_lock lock(mutex_);
    const auto may_wait = [&] { return refusal(id) != kFlushing; };
    ++waiting_for_runner_;
    changed_.wait(lock, [&] { return (!another_runs() && !another_sends()) || !may_wait(); });
    --waiting_for_runner_;
    if (!may_wait()) return false;
    const auto used = [&] { return use(), taken(); };
    if (!running_) return run(lock, used), true;
    lock.unlock();  // this thread runs already
    used();
    return true;
  }

  typename Lanes<Frame>::Counts counts() const {
    std::lock_guard lock(mutex_);
    return lanes_.counts();
  }
  // Now, and the most since start().
  std::pair<uint64_t, uint64_t> bytes_held() const {
    std::lock_guard lock(mutex_);
    return {lanes_.held_bytes(), most_bytes_};
  }
  size_t waiting() const {  // threads
    std::lock_guard lock(mutex_);
    return waiting_;
  }

 private:
  using Lock = std::unique_lock<std::mutex>;

  bool is_flushing(LaneId id) const {
    return std::find(flushing_.begin(), flushing_.end(), id) != flushing_.end();
  }
  bool another_sends() const {
    return flush_sender_ && *flush_sender_ != std::this_thread::get_id();
  }
  bool another_runs() const { return running_ && runner_ != std::this_thread::get_id(); }
  void wait_for_runner(Lock& lock) {
    ++waiting_for_runner_;
    changed_.wait(lock, [this] { return !another_runs() && !another_sends(); });
    --waiting_for_runner_;
  }
  bool end_flush(Lock& lock) {
    if (!flushing_.empty() || !output_flushes_) return false;
    wait_for_runner(lock);
    if (!flushing_.empty() || !output_flushes_) return false;  // meanwhile
    output_flushes_ = false;
    flush_sender_ = std::this_thread::get_id();
    lanes_.forget(DropReason::Flush);
    flow_ = kOk;
    linked_ = true;
    tell();
    return true;
  }
  int refusal(LaneId id) {
    const auto* lane = lanes_.find(id);
    if (!started_ || !lane || !lane->active || is_flushing(id)) return kFlushing;
    if (lane->ended) return kEnded;
    return flow_;
  }
  static DropReason reason_of(int flow) {
    if (flow == kFlushing) return DropReason::Flush;
    return flow == kEnded ? DropReason::Eos : DropReason::Error;
  }

  int taken() const { return linked_ ? kOk : kNotLinked; }

  bool has_room(uint64_t bytes) const {
    const uint64_t held = lanes_.held_bytes();
    return max_bytes_ == 0 || held == 0 || (held <= max_bytes_ && bytes <= max_bytes_ - held);
  }
  int wait_for_bytes(Lock& lock, LaneId id, uint64_t bytes) {
    while (!has_room(bytes)) {
      const bool flushes = !flushing_.empty();  // what is held may be used when it ends
      if (!running_ && !flushes && !advance(lock)) return beyond_bytes(lock, bytes);
      if (running_ || flushes) {
        ++waiting_, ++waiting_for_runner_;
        changed_.wait(lock);
        --waiting_, --waiting_for_runner_;
      }
      if (const int refused = refusal(id); refused != kOk) {
        ledger_->dropped(reason_of(refused));
        return refused;
      }
    }
    return kOk;
  }
  // Nothing is in work, and the policy has no use for what is held: it would wait for ever.
  int beyond_bytes(Lock& lock, uint64_t bytes) {
    const uint64_t held = lanes_.held_bytes();
    const std::string needed = std::to_string(held + bytes);
    const Error error{Code::LIMIT_EXCEEDED,
                      "frames that go together are more bytes than max-bytes allows",
                      std::to_string(held) + " bytes held and a frame of " + std::to_string(bytes) +
                          " beside them, max-bytes=" + std::to_string(max_bytes_),
                      "max-bytes of " + needed + " or more, 0 = any",
                      "",
                      "max-bytes=" + needed};
    ledger_->dropped(DropReason::Error);
    lock.unlock();
    consumer_->refused(error);  // before others fail, who know no reason
    lock.lock();
    flow_ = kRefused;
    tell();
    return kRefused;
  }

  int wait_until_taken(Lock& lock, LaneId id) {
    while (true) {
      if (const int refused = refusal(id); refused != kOk) {
        lanes_.drop_head(id, reason_of(refused));
        return refused;
      }
      auto* lane = lanes_.find(id);
      if (!lane->head && waiting_ > 0) return taken();  // the others go on by themselves
      if (advance(lock)) continue;
      if (!lane->head) return taken();
      if (lane->may_wait || running_) {
        wait(lock, *lane);
        continue;
      }
      lane->may_wait = true;
      if (!ask_to_wait(lock, id)) return kRefused;
    }
  }

  void work(Lock& lock) {
    while (started_ && flow_ == kOk && advance(lock)) {
    }
  }

  // One step of the policy. False: nothing could be done. Downstream takes nothing until FLUSH_STOP
  // was sent.
  bool advance(Lock& lock) {
    if (another_sends()) {
      ++waiting_;
      changed_.wait(lock, [this] { return !another_sends(); });
      --waiting_;
      return true;
    }
    if (running_ || !flushing_.empty()) return false;
    auto step = lanes_.step(options_);
    if (!step) {
      run(lock, [&] {
        consumer_->refused(step.error());
        return kRefused;
      });
      return true;
    }
    if (step->changed && step->outcome == Outcome::Wait) tell();
    if (step->outcome == Outcome::Emit)
      run(lock, [&] { return consumer_->emit(std::move(step->emission)); });
    if (step->outcome == Outcome::End)
      run(lock, [&] {
        consumer_->end();
        return kEnded;
      });
    return step->changed || step->outcome != Outcome::Wait;
  }

  template <class F>
  void run(Lock& lock, F&& f) {
    running_ = true;
    runner_ = std::this_thread::get_id();
    ++changes_;
    lock.unlock();
    changed_.notify_all();  // those whose heads were taken
    int flow = f();
    lock.lock();
    running_ = false;
    linked_ = flow != kNotLinked;
    if (!linked_) flow = kOk;
    // Where one pad flushes, what is lost behind is no matter of the others.
    if (flow != kOk && !(flow == kFlushing && !flushing_.empty())) flow_ = flow;
    if (!all_may_sleep()) tell();
  }
  // After an output: those who wait are woken only where one of them has something to do.
  bool all_may_sleep() const {
    if (flow_ != kOk || waiting_for_runner_ > 0 || max_wait_ > Clock::duration::zero() ||
        !flushing_.empty())
      return false;
    const auto& lanes = lanes_.all();
    return std::all_of(lanes.begin(), lanes.end(), [](auto& l) { return !l.head || l.may_wait; }) &&
           lanes_.must_wait(options_.mode);
  }

  bool ask_to_wait(Lock& lock, LaneId id) {
    std::vector<LaneId> empty;
    for (const auto& lane : lanes_.all())
      if (!lane.head && !lane.ended && !lane.missing &&
          !(lane.kept && options_.mode == Mode::Refresh))
        empty.push_back(lane.id);
    if (empty.empty() || max_wait_ > Clock::duration::zero()) return true;
    lock.unlock();
    const Status status = consumer_->may_wait(id, empty);
    if (!status) consumer_->refused(status.error());  // before others fail, who know no reason
    lock.lock();
    if (status) return true;
    flow_ = kRefused;
    lanes_.drop_head(id, DropReason::Error);
    tell();
    return false;
  }

  void wait(Lock& lock, const typename Lanes<Frame>::Lane& lane) {
    const auto since = lane.arrived;
    const LaneId id = lane.id;
    if (waited_behind_gaps(lock, id)) return;
    ++waiting_;
    std::optional<Clock::time_point> deadline;
    if (max_wait_ > Clock::duration::zero()) deadline = lanes_.next_deadline(since, max_wait_);
    if (!deadline)
      changed_.wait(lock);
    else if (changed_.wait_until(lock, *deadline) == std::cv_status::timeout)
      if (lanes_.mark_missing(since, max_wait_, Clock::now())) tell();
    --waiting_;
  }
  // Of one that is not told yet; empty with max-wait, which ends the wait.
  std::vector<LaneId> gaps_before(LaneId id) {
    if (told_of_gaps_ || max_wait_ > Clock::duration::zero()) return {};
    return lanes_.waited_for_behind_gaps(options_.mode, id);
  }
  bool a_head_waits_behind_gaps() {
    const auto& lanes = lanes_.all();
    return std::any_of(lanes.begin(), lanes.end(),
                       [this](const auto& lane) { return !gaps_before(lane.id).empty(); });
  }
  // Who waits behind gaps may wait for ever: the user is told. False: it is none of them.
  bool waited_behind_gaps(Lock& lock, LaneId id) {
    const uint64_t before = changes_;
    const auto gaps = gaps_before(id);
    if (gaps.empty()) return false;
    ++waiting_;
    changed_.wait_for(lock, gap_patience_, [&] { return changes_ != before; });
    --waiting_;
    if (changes_ != before) return true;
    told_of_gaps_ = true;
    lock.unlock();
    consumer_->waits_behind_gaps(id, gaps);
    lock.lock();
    return true;
  }
  void tell() {
    ++changes_;
    changed_.notify_all();
  }

  mutable std::mutex mutex_;  // guards everything below; never held while consumer_ is called
  std::condition_variable changed_;
  Ledger* const ledger_;
  Consumer<Frame>* const consumer_;
  const Clock::duration gap_patience_;
  Lanes<Frame> lanes_;
  Options options_;
  OnBackwardsTime backwards_ = OnBackwardsTime::Pass;
  Clock::duration max_wait_{};  // 0 = for ever
  uint64_t max_bytes_ = 0, most_bytes_ = 0;
  LaneId last_id_ = 0;
  std::vector<LaneId> flushing_;
  bool output_flushes_ = false;                  // from flush_start() to flush_stop() with true
  std::optional<std::thread::id> flush_sender_;  // sends FLUSH_START or FLUSH_STOP downstream
  int flow_ = kOk;
  bool linked_ = true;  // when the last output left
  bool started_ = false, told_of_gaps_ = false;
  uint64_t changes_ = 0;
  bool running_ = false;  // runner_ makes an output
  std::thread::id runner_;
  size_t waiting_ = 0;
  size_t waiting_for_runner_ = 0;  // until running_ is false
};

}  // namespace weir::sync
