// Collector: combines the frames of several pads, each with its own thread, by a sync policy.
//
// Each frame is handled on the thread that delivers it: offer() returns when the policy has taken
// the frame, and the thread whose frame completes an output makes that output. The collector has no
// thread of its own. Flush, end, removal of the pad and stop wake everything that waits here.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "core/sync/consumer.hpp"

namespace weir::sync {

inline constexpr Clock::duration kGapTimeout = std::chrono::seconds(1);
inline constexpr Clock::duration kSilenceTimeout = std::chrono::seconds(10);

template <class Frame>
class Collector {
 public:
  Collector(Ledger* ledger, Consumer<Frame>* consumer, Clock::duration gap_timeout = kGapTimeout,
            Clock::duration silence_timeout = kSilenceTimeout)
      : ledger_(ledger),
        consumer_(consumer),
        gap_patience_(gap_timeout),
        silence_patience_(silence_timeout),
        queues_(ledger) {}

  // `max_bytes` limits the bytes of all held frames, 0 = no limit; a single frame may exceed it.
  void configure(const Options& options, OnBackwardsTime backwards, Clock::duration max_wait,
                 uint64_t max_bytes = 0) {
    std::lock_guard lock(mutex_);
    max_bytes_ = max_bytes;
    options_ = options;
    backwards_ = backwards;
    max_wait_ = max_wait;
    wake_all();
  }
  void start() {
    std::unique_lock lock(mutex_);
    wait_for_runner(lock);  // proceed() may still push output from before stop()
    queues_.clear_all(DropReason::Flush);
    for (const auto& queue : queues_.all()) queues_.begin(queue.id);
    flow_ = kOk;
    peak_bytes_ = 0;
    linked_ = started_ = true;
    gaps_reported_ = silence_reported_ = false;
  }
  void stop() {
    std::lock_guard lock(mutex_);
    started_ = false;
    queues_.clear_all(DropReason::Flush);
    flushing_.clear();
    output_flushes_ = false;
    wake_all();
  }

  QueueId add() {
    std::lock_guard lock(mutex_);
    queues_.add(++last_id_);
    return last_id_;
  }
  // Returns true if the output flushed only for this queue; then act as for flush_stop(). Makes no
  // output: call proceed() on a thread that may block to make outputs that the removal enables.
  bool remove(QueueId id) {
    std::unique_lock lock(mutex_);
    queues_.remove(id);
    std::erase(flushing_, id);
    wake_all();
    return end_flush(lock);
  }
  void proceed() {
    std::unique_lock lock(mutex_);
    work(lock);
  }

  // Adds a frame to the queue and waits until the policy has taken it; use one thread per queue.
  // Above max_bytes it waits as long as outputs in progress can free memory. If none can, the limit
  // is too small for the streams: LIMIT_EXCEEDED.
  int offer(QueueId id, Frame frame, Stamp time, uint64_t bytes = 0) {
    std::unique_lock lock(mutex_);
    ledger_->received();
    if (const int refused = wait_for_bytes(lock, id, bytes); refused != kOk) return refused;
    if (!queues_.put(id, std::move(frame), time, backwards_, bytes)) return kOk;
    peak_bytes_ = std::max(peak_bytes_, queues_.held_bytes());
    return wait_until_taken(lock, id);
  }
  // No frame before `end` will arrive.
  void gap(QueueId id, Time end) {
    std::unique_lock lock(mutex_);
    const bool waited = is_waiting_for_gap_only_pads();
    queues_.gap(id, end);
    work(lock);
    // Restarts the time-out of the waiting threads.
    if (!waited && is_waiting_for_gap_only_pads()) wake_all();
  }
  void end(QueueId id) {
    std::unique_lock lock(mutex_);
    queues_.end(id);
    work(lock);
  }
  void begin(QueueId id) {
    std::lock_guard lock(mutex_);
    queues_.begin(id);
  }

  // An inactive queue accepts nothing; a thread that waits there returns.
  void set_active(QueueId id, bool active) {
    std::lock_guard lock(mutex_);
    auto* queue = queues_.find(id);
    if (!queue) return;
    queue->active = active;
    if (!active) queues_.drop_head(id, DropReason::Flush);
    wake_all();
  }

  // Returns true for the first flushing queue: the caller then sends FLUSH_START downstream and
  // calls flush_sent().
  [[nodiscard]] bool flush_start(QueueId id) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !another_sends(); });
    if (!queues_.find(id)) return false;  // removed during the wait
    if (!is_flushing(id)) flushing_.push_back(id);
    queues_.drop_head(id, DropReason::Flush);
    wake_all();
    if (output_flushes_) return false;
    flush_sender_ = std::this_thread::get_id();
    return output_flushes_ = true;
  }
  // Returns true for the last flushing queue: the caller then sends FLUSH_STOP downstream and calls
  // flush_sent(). Waits until the current emission has finished.
  [[nodiscard]] bool flush_stop(QueueId id) {
    std::unique_lock lock(mutex_);
    if (std::erase(flushing_, id) == 0) return false;
    queues_.begin(id);
    return end_flush(lock);
  }
  // Reports that the event was sent: FLUSH_START and FLUSH_STOP leave in the order of their
  // decisions.
  void flush_sent() {
    std::lock_guard lock(mutex_);
    flush_sender_.reset();
    wake_all();
  }

  // Calls `use` while no output is made, for everything but frames that a queue sends downstream.
  // Returns false without calling it if the queue is inactive, flushes or was removed.
  template <class Use>
  bool use_output(QueueId id, Use&& use) {
    std::unique_lock lock(mutex_);
    const auto may_wait = [&] { return refusal(id) != kFlushing; };
    ++waiting_for_runner_;
    changed_.wait(lock, [&] { return (!another_runs() && !another_sends()) || !may_wait(); });
    --waiting_for_runner_;
    if (!may_wait()) return false;
    const auto used = [&] { return use(), taken(); };
    if (!running_) return run(lock, used), true;
    lock.unlock();  // this thread is already the runner
    used();
    return true;
  }

  typename InputQueues<Frame>::Counts counts() const {
    std::lock_guard lock(mutex_);
    return queues_.counts();
  }
  // The current value, and the maximum since start().
  std::pair<uint64_t, uint64_t> bytes_held() const {
    std::lock_guard lock(mutex_);
    return {queues_.held_bytes(), peak_bytes_};
  }
  size_t waiting() const {  // threads
    std::lock_guard lock(mutex_);
    return waiting_;
  }

 private:
  using Lock = std::unique_lock<std::mutex>;

  bool is_flushing(QueueId id) const {
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
    if (!flushing_.empty() || !output_flushes_) return false;  // changed during the wait
    output_flushes_ = false;
    flush_sender_ = std::this_thread::get_id();
    queues_.forget(DropReason::Flush);
    flow_ = kOk;
    linked_ = true;
    wake_all();
    return true;
  }
  int refusal(QueueId id) {
    const auto* queue = queues_.find(id);
    if (!started_ || !queue || !queue->active || is_flushing(id)) return kFlushing;
    if (queue->ended) return kEnded;
    return flow_;
  }
  static DropReason to_drop_reason(int flow) {
    if (flow == kFlushing) return DropReason::Flush;
    return flow == kEnded ? DropReason::Eos : DropReason::Error;
  }

  int taken() const { return linked_ ? kOk : kNotLinked; }

  bool has_room(uint64_t bytes) const {
    const uint64_t held = queues_.held_bytes();
    return max_bytes_ == 0 || held == 0 || (held <= max_bytes_ && bytes <= max_bytes_ - held);
  }
  int wait_for_bytes(Lock& lock, QueueId id, uint64_t bytes) {
    while (true) {
      if (const int refused = refusal(id); refused != kOk) {
        ledger_->dropped(to_drop_reason(refused));
        return refused;
      }
      if (has_room(bytes)) return kOk;
      const bool flushes = !flushing_.empty();  // held frames may be used when the flush ends
      if (!running_ && !flushes && !advance(lock)) return beyond_bytes(lock, bytes);
      if (running_ || flushes) {
        ++waiting_, ++waiting_for_runner_;
        changed_.wait(lock);
        --waiting_, --waiting_for_runner_;
      }
    }
  }
  // No output is in progress and the policy cannot use the held frames, so waiting would never end.
  int beyond_bytes(Lock& lock, uint64_t bytes) {
    const uint64_t held = queues_.held_bytes();
    const std::string needed = std::to_string(held + bytes);
    const Error error{.code = Code::LIMIT_EXCEEDED,
                      .what = "the frames of one output exceed max-bytes",
                      .offered = std::to_string(held) + " bytes held and a frame of " +
                                 std::to_string(bytes) +
                                 " in addition, max-bytes=" + std::to_string(max_bytes_),
                      .needed = "max-bytes of " + needed + " or more, or 0 for no limit",
                      .fix = "max-bytes=" + needed};
    ledger_->dropped(DropReason::Error);
    refuse(lock, error);
    return kRefused;
  }

  void refuse(Lock& lock, const Error& error) {
    lock.unlock();
    consumer_->refused(error);  // before other pads fail without a reason
    lock.lock();
    flow_ = kRefused;
    wake_all();
  }

  int wait_until_taken(Lock& lock, QueueId id) {
    while (true) {
      if (const int refused = refusal(id); refused != kOk) {
        queues_.drop_head(id, to_drop_reason(refused));
        return refused;
      }
      auto* queue = queues_.find(id);
      // The waiting threads continue on their own.
      if (!queue->head && waiting_ > 0) return taken();
      if (advance(lock)) continue;
      if (!queue->head) return taken();
      if (queue->may_wait || running_) {
        wait(lock, *queue);
        continue;
      }
      queue->may_wait = true;
      if (!ask_to_wait(lock, id)) return kRefused;
    }
  }

  void work(Lock& lock) {
    while (started_ && flow_ == kOk && advance(lock)) {
    }
  }

  // One step of the policy. False: nothing could be done. Downstream accepts nothing until
  // FLUSH_STOP was sent.
  bool advance(Lock& lock) {
    if (another_sends()) {
      ++waiting_;
      changed_.wait(lock, [this] { return !another_sends(); });
      --waiting_;
      return true;
    }
    if (running_ || !flushing_.empty()) return false;
    auto step = queues_.step(options_);
    if (!step) {
      run(lock, [&] {
        consumer_->refused(step.error());
        return kRefused;
      });
      return true;
    }
    if (step->changed && step->outcome == Outcome::Wait) wake_all();
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
    changed_.notify_all();  // for the threads whose heads were taken
    int flow = f();
    lock.lock();
    running_ = false;
    linked_ = flow != kNotLinked;
    if (!linked_) flow = kOk;
    // While one pad flushes, output lost downstream does not concern the others.
    if (flow != kOk && !(flow == kFlushing && !flushing_.empty())) flow_ = flow;
    if (!all_may_sleep()) wake_all();
  }
  // After an output, waiting threads are woken only if one of them can do something.
  bool all_may_sleep() const {
    if (flow_ != kOk || waiting_for_runner_ > 0 || max_wait_ > Clock::duration::zero() ||
        !flushing_.empty())
      return false;
    const auto& queues = queues_.all();
    return std::all_of(queues.begin(), queues.end(),
                       [](auto& l) { return !l.head || l.may_wait; }) &&
           queues_.must_wait(options_.mode);
  }

  std::vector<QueueId> empty_queues() const {
    std::vector<QueueId> empty;
    for (const auto& queue : queues_.all())
      if (!queue.head && !queue.ended && !queue.missing &&
          !(queue.kept && options_.mode == Mode::Refresh))
        empty.push_back(queue.id);
    return empty;
  }
  bool ask_to_wait(Lock& lock, QueueId id) {
    const auto empty = empty_queues();
    if (empty.empty() || max_wait_ > Clock::duration::zero()) return true;
    lock.unlock();
    const Status status = consumer_->may_wait(id, empty);
    lock.lock();
    if (status) return true;
    refuse(lock, status.error());
    queues_.drop_head(id, DropReason::Error);
    return false;
  }

  void wait(Lock& lock, const typename InputQueues<Frame>::InputQueue& queue) {
    const auto since = queue.arrived;
    const QueueId id = queue.id;
    if (waited_for_gap_only_pads(lock, id)) return;
    ++waiting_;
    std::optional<Clock::time_point> deadline;
    if (max_wait_ > Clock::duration::zero()) deadline = queues_.next_deadline(since, max_wait_);
    if (!deadline)
      wait_for_change(lock, id);
    else if (changed_.wait_until(lock, *deadline) == std::cv_status::timeout)
      if (queues_.mark_missing(since, max_wait_, Clock::now())) wake_all();
    --waiting_;
  }
  // False: nothing changed within `timeout`, so the wait may never end.
  bool waited_for_change(Lock& lock, Clock::duration timeout) {
    const uint64_t before = changes_;
    return changed_.wait_for(lock, timeout, [&] { return changes_ != before; });
  }
  void wait_for_change(Lock& lock, QueueId id) {
    if (silence_reported_) return changed_.wait(lock);
    if (waited_for_change(lock, silence_patience_)) return;
    const auto silent = empty_queues();
    if (running_ || silence_reported_ || silent.empty()) return;
    silence_reported_ = true;  // by this thread alone
    lock.unlock();
    const bool reported = consumer_->waits_for_silent_pads(id, silent);
    lock.lock();
    silence_reported_ = reported;
  }
  // Gaps that are not reported yet; empty with max-wait, which ends the wait.
  std::vector<QueueId> gaps_before(QueueId id) {
    if (gaps_reported_ || max_wait_ > Clock::duration::zero()) return {};
    return queues_.gap_only_queues(options_.mode, id);
  }
  bool is_waiting_for_gap_only_pads() {
    const auto& queues = queues_.all();
    return std::any_of(queues.begin(), queues.end(),
                       [this](const auto& queue) { return !gaps_before(queue.id).empty(); });
  }
  // Returns false if this is not a wait for pads that only send gaps.
  bool waited_for_gap_only_pads(Lock& lock, QueueId id) {
    const auto gaps = gaps_before(id);
    if (gaps.empty()) return false;
    ++waiting_;
    const bool has_changed = waited_for_change(lock, gap_patience_);
    --waiting_;
    if (has_changed) return true;
    gaps_reported_ = true;
    lock.unlock();
    consumer_->waits_for_gap_only_pads(id, gaps);
    lock.lock();
    return true;
  }
  void wake_all() {
    ++changes_;
    changed_.notify_all();
  }

  mutable std::mutex mutex_;  // guards everything below; never held while consumer_ is called
  std::condition_variable changed_;
  Ledger* const ledger_;
  Consumer<Frame>* const consumer_;
  const Clock::duration gap_patience_, silence_patience_;
  InputQueues<Frame> queues_;
  Options options_;
  OnBackwardsTime backwards_ = OnBackwardsTime::Pass;
  Clock::duration max_wait_{};  // 0 = no limit
  uint64_t max_bytes_ = 0, peak_bytes_ = 0;
  QueueId last_id_ = 0;
  std::vector<QueueId> flushing_;
  bool output_flushes_ = false;  // from flush_start() until flush_stop() returns true
  std::optional<std::thread::id> flush_sender_;  // the thread that sends FLUSH_START or FLUSH_STOP
  int flow_ = kOk;
  bool linked_ = true;  // whether the last output reached a linked pad
  bool started_ = false, gaps_reported_ = false, silence_reported_ = false;
  uint64_t changes_ = 0;
  bool running_ = false;  // runner_ is making an output
  std::thread::id runner_;
  size_t waiting_ = 0;
  size_t waiting_for_runner_ = 0;  // threads that wait until running_ is false
};

}  // namespace weir::sync
