// SharedOutput<Input>: several inputs, each with its own thread, push to one output in turn.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

namespace weir::sync {

// Inputs push in order of arrival. The last one to arrive is the active input, even while it waits
// for its turn. A thread that waits for the output returns as soon as its input is closed, so that
// an input can flush, stop and be removed while another one blocks in the output. While the output
// flushes for one input, the others wait. Input() means no input.
template <class Input>
class SharedOutput {
 public:
  enum class Access {
    Denied,    // the input is closed
    Granted,   // this input also pushed last; call release()
    Switched,  // another input pushed last, or this one was skipped; call release()
  };

  // An input is closed before open() and after close(), while it is inactive or flushes.
  void open(const Input& input) {
    std::lock_guard lock(mutex_);
    if (!is_open(input)) open_.push_back(input);
  }
  // Returns true if the input uses the output at this time; then its thread comes back late.
  bool close(const Input& input) {
    std::lock_guard lock(mutex_);
    std::erase(open_, input);
    changed_.notify_all();
    return user_ == input;
  }

  // Waits until no other input uses the output. Returns false if the input is closed.
  [[nodiscard]] bool acquire(const Input& input) {
    std::unique_lock lock(mutex_);
    return wait_for_turn(lock, input, false);
  }
  // The same, and makes the input active at once.
  Access acquire_as_active(const Input& input) {
    std::unique_lock lock(mutex_);
    if (!wait_for_turn(lock, input, true)) return Access::Denied;
    const bool was_skipped = std::exchange(skipped_, false);
    return std::exchange(last_, input) == input && !was_skipped ? Access::Granted
                                                                : Access::Switched;
  }
  // Waits until the input is closed, is no longer active, or `over` returns true, but at most
  // `timeout`. Returns true after a time-out. Calls `over` with the lock held after each
  // release().
  template <class Over>
  bool stays_active(const Input& input, std::chrono::steady_clock::duration timeout, Over&& over) {
    std::unique_lock lock(mutex_);
    return !changed_.wait_for(
        lock, timeout, [&] { return !is_open(input) || !(active_now() == input) || over(); });
  }
  // Calls the `over` of those that wait in stays_active().
  void wake() {
    std::lock_guard lock(mutex_);
    changed_.notify_all();
  }
  // The input, which is not active, had something to send that the output does not get.
  void pass_over(const Input& input) {
    std::lock_guard lock(mutex_);
    skipped_ = skipped_ || last_ == input;
  }
  void release() {
    std::lock_guard lock(mutex_);
    user_ = Input();
    changed_.notify_all();
  }

  // The input starts to flush. Returns true if it pushed last: the caller then sends FLUSH_START
  // downstream and calls flush_sent().
  [[nodiscard]] bool flush_start(const Input& input) {
    std::unique_lock lock(mutex_);
    std::erase(open_, input);
    changed_.notify_all();
    wait_for_sender(lock);
    if (!(last_ == input) || flushing_ == input) return false;
    flushing_ = input;
    sender_ = std::this_thread::get_id();
    return true;
  }
  // Returns true if the output flushes for this input: the caller then sends FLUSH_STOP downstream
  // and calls flush_sent(). The caller calls open() when the input accepts buffers again.
  [[nodiscard]] bool flush_stop(const Input& input) {
    std::unique_lock lock(mutex_);
    wait_for_sender(lock);
    if (flushing_ == Input() || !(flushing_ == input)) return false;
    sender_ = std::this_thread::get_id();
    stops_flush_ = true;
    return true;
  }
  // Reports that the event was sent: FLUSH_START and FLUSH_STOP leave in the order of their
  // decisions.
  void flush_sent() {
    std::lock_guard lock(mutex_);
    if (std::exchange(stops_flush_, false)) flushing_ = Input();
    sender_.reset();
    changed_.notify_all();
  }

  // Removes the input, after close(). Returns true if it was active.
  bool remove(const Input& input) {
    std::lock_guard lock(mutex_);
    std::erase(open_, input);
    changed_.notify_all();
    const bool was_active = active_now() == input;
    if (last_ == input) last_ = Input();
    return was_active;
  }
  // Makes no input active and ends all flushes; open inputs stay open.
  void reset() {
    std::lock_guard lock(mutex_);
    last_ = flushing_ = Input();
    skipped_ = false;
    changed_.notify_all();
  }

  Input active() const {
    std::lock_guard lock(mutex_);
    return active_now();
  }
  size_t waiting() const {  // threads in acquire()
    std::lock_guard lock(mutex_);
    return waiting_.size();
  }

 private:
  using Lock = std::unique_lock<std::mutex>;
  struct Waiter {
    uint64_t ticket = 0;
    Input input{};
    bool as_active = false;
  };

  Input active_now() const {
    const auto found = std::find_if(waiting_.rbegin(), waiting_.rend(),
                                    [](const Waiter& w) { return w.as_active; });
    return found == waiting_.rend() ? last_ : found->input;
  }
  bool is_open(const Input& input) const {
    return std::find(open_.begin(), open_.end(), input) != open_.end();
  }
  // Returns false if the input is closed.
  bool wait_for_turn(Lock& lock, const Input& input, bool as_active) {
    const uint64_t ticket = next_ticket_++;
    if (is_open(input)) waiting_.push_back({ticket, input, as_active});
    const auto is_free = [&] {
      return user_ == Input() && flushing_ == Input() && waiting_.front().ticket == ticket;
    };
    changed_.wait(lock, [&] { return !is_open(input) || is_free(); });
    std::erase_if(waiting_, [ticket](const Waiter& w) { return w.ticket == ticket; });
    if (is_open(input)) {
      user_ = input;
      return true;
    }
    changed_.notify_all();  // the next waiter may be first now
    return false;
  }
  void wait_for_sender(Lock& lock) {
    changed_.wait(lock, [this] { return !sender_ || *sender_ == std::this_thread::get_id(); });
  }

  mutable std::mutex mutex_;  // guards everything below; never held while the output is used
  std::condition_variable changed_;
  std::vector<Input> open_;
  std::vector<Waiter> waiting_;  // in order of arrival
  uint64_t next_ticket_ = 0;
  Input last_{}, flushing_{};  // last_: the input that pushed last
  Input user_{};               // the input that uses the output
  bool skipped_ = false;       // last_ was skipped since it pushed
  bool stops_flush_ = false;
  std::optional<std::thread::id> sender_;  // the thread that sends FLUSH_START or FLUSH_STOP
};

}  // namespace weir::sync
