// FrameQueue: frames on their way from a stream's thread to a program's.
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

  // Empty, with room for `limit` frames; 0: for any number.
  void open(size_t limit, Full full) {
    std::lock_guard lock(mutex_);
    frames_.clear();
    limit_ = limit;
    full_ = full;
    closed_ = ended_ = false;
  }
  // Lets everybody go who waits; what is put from now on is dropped.
  void close() {
    std::lock_guard lock(mutex_);
    closed_ = true;
    frames_.clear();
    changed_.notify_all();
  }
  // The stream has ended: what is inside can still be taken.
  void end() {
    std::lock_guard lock(mutex_);
    ended_ = true;
    changed_.notify_all();
  }
  // Wakes waiting calls, whose `interrupted` has changed.
  void wake() {
    std::lock_guard lock(mutex_);
    changed_.notify_all();
  }

  // A flush: wait_for_room() returns, also where the flush has ended before it looks.
  void flush() {
    std::lock_guard lock(mutex_);
    ++flushes_;
    changed_.notify_all();
  }

  // Waits until put() has room, the queue is closed, flush(), or interrupted(). Returns at once
  // where put() drops the oldest frame.
  template <class Interrupted>
  void wait_for_room(Interrupted&& interrupted) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&, flushes = flushes_] {
      return has_room() || full_ == Full::DropsOldest || closed_ || flushes_ != flushes ||
             interrupted();
    });
  }
  // Never waits. A frame that comes without wait_for_room() is kept beyond the limit.
  void put(Frame frame) {
    std::lock_guard lock(mutex_);
    if (closed_) return;
    if (full_ == Full::DropsOldest && !has_room()) frames_.pop_front();
    frames_.push_back(std::move(frame));
    changed_.notify_all();
  }

  // Nothing when the time has passed, the stream has ended, the queue is closed, or interrupted().
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
  // The stream has ended and everything was taken.
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
