// FrameQueue: passes frames from a streaming thread to a program's thread.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

namespace weir::pipeline {

enum class Full { Waits, DropsOldest };

// Thread-safe.
template <class Frame>
class FrameQueue {
 public:
  using Time = std::optional<std::chrono::steady_clock::time_point>;  // nullopt: no limit

  // Empties the queue and sets its limit in frames; 0: unlimited.
  void open(size_t limit, Full full) {
    std::lock_guard lock(mutex_);
    frames_.clear();
    limit_ = limit;
    full_ = full;
    closed_ = ended_ = false;
  }
  // Wakes all waiting threads; frames that are put from now on are dropped.
  void close() {
    std::lock_guard lock(mutex_);
    closed_ = true;
    frames_.clear();
    changed_.notify_all();
  }
  // The stream has ended: queued frames can still be taken.
  void end() {
    std::lock_guard lock(mutex_);
    ended_ = true;
    changed_.notify_all();
  }
  // Wakes waiting calls to check `interrupted` again.
  void wake() {
    std::lock_guard lock(mutex_);
    changed_.notify_all();
  }

  // Makes wait_for_room() return, even if the flush ends before it wakes.
  void flush() {
    std::lock_guard lock(mutex_);
    ++flushes_;
    changed_.notify_all();
  }

  // Waits until put() has room, close(), flush(), or interrupted(). Returns immediately if put()
  // drops the oldest frame.
  template <class Interrupted>
  void wait_for_room(Interrupted&& interrupted) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&, flushes = flushes_] {
      return has_room() || full_ == Full::DropsOldest || closed_ || flushes_ != flushes ||
             interrupted();
    });
  }
  // Never waits. A frame put without wait_for_room() may exceed the limit.
  void put(Frame frame) {
    std::lock_guard lock(mutex_);
    if (closed_) return;
    if (full_ == Full::DropsOldest && !has_room()) frames_.pop_front();
    frames_.push_back(std::move(frame));
    changed_.notify_all();
  }

  // nullopt on timeout, end of stream, close(), or interrupted().
  template <class Interrupted>
  std::optional<Frame> take(Time until, Interrupted&& interrupted) {
    std::unique_lock lock(mutex_);
    const auto over = [&] { return !frames_.empty() || ended_ || closed_ || interrupted(); };
    if (until)
      changed_.wait_until(lock, *until, over);
    else
      changed_.wait(lock, over);
    if (frames_.empty()) return std::nullopt;
    std::optional<Frame> out(std::move(frames_.front()));
    frames_.pop_front();
    changed_.notify_all();
    return out;
  }
  // Whether the stream has ended and all frames were taken.
  bool ended() const {
    std::lock_guard lock(mutex_);
    return ended_ && frames_.empty();
  }
  bool closed() const {
    std::lock_guard lock(mutex_);
    return closed_;
  }

 private:
  bool has_room() const { return limit_ == 0 || frames_.size() < limit_; }

  mutable std::mutex mutex_;  // guards the rest
  std::condition_variable changed_;
  uint64_t flushes_ = 0;
  std::deque<Frame> frames_;
  size_t limit_ = 0;
  Full full_ = Full::Waits;
  bool closed_ = true, ended_ = false;
};

}  // namespace weir::pipeline
