// HeldBytes: one limit for the bytes of frames being processed elsewhere and of results waiting to
// leave.
//
// The limit never stalls a stream: a frame or result is accepted whatever its size if it is alone.
// All functions are thread-safe.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "core/infer/queue/busy_policy.hpp"

namespace weir::infer {

class HeldBytes {
 public:
  // `limit` in bytes, 0 = no limit. `when_busy` decides what happens at the limit.
  HeldBytes(uint64_t limit, WhenBusy when_busy) : limit_(limit), when_busy_(when_busy) {}
  HeldBytes(const HeldBytes&) = delete;
  HeldBytes& operator=(const HeldBytes&) = delete;
  uint64_t limit() const noexcept { return limit_; }

  // The bytes of a frame, from its acceptance until this object is destroyed.
  class Share {
   public:
    Share() = default;
    Share(Share&& other) noexcept
        : held_(std::move(other.held_)), bytes_(std::exchange(other.bytes_, 0)) {}
    Share& operator=(Share&& other) noexcept {
      std::swap(held_, other.held_);
      std::swap(bytes_, other.bytes_);
      return *this;
    }
    ~Share() {
      if (held_) held_->release_frame(bytes_);
    }

   private:
    friend class HeldBytes;
    std::shared_ptr<HeldBytes> held_;
    uint64_t bytes_ = 0;
  };
  enum class FrameAdmission {
    Taken,
    Full,     // does not fit; not for calls that wait
    Refused,  // between refuse() or refuse_frames() and resume()
  };
  // Accounts for a new frame. try_frame never waits; take_frame waits for space if `when_busy` is
  // Block.
  static FrameAdmission try_frame(const std::shared_ptr<HeldBytes>& held, uint64_t bytes,
                                  Share* share);
  static FrameAdmission take_frame(const std::shared_ptr<HeldBytes>& held, uint64_t bytes,
                                   Share* share);

  // The queue of the results. Called with the lock held; must not call back.
  class Results {
   public:
    virtual ~Results() = default;
    // Results leave the queue without the engine's help, so a waiting caller gets space.
    virtual bool leave() const = 0;
    // The new result would be the next to leave.
    virtual bool is_next() const = 0;
    // Drops the oldest queued result and returns its bytes; nullopt: none is queued.
    virtual std::optional<uint64_t> drop_oldest() = 0;
  };
  enum class Room {
    Taken,
    Dropped,
    Stuck,    // the held bytes wait for the engine, which would wait here
    Refused,  // between refuse() and resume()
  };
  // For a result of an engine. Block: waits while others leave. DropOld: replaces older ones.
  Room take_result(uint64_t bytes, Results& results);
  void release_result(uint64_t bytes);
  // Results have left or ended: wakes waiting callers.
  void moved();

  // Wakes waiting callers and rejects everything until resume().
  void refuse();
  // The same for frames only; results of earlier frames are still accepted.
  void refuse_frames();
  void resume();

  struct State {
    uint64_t held = 0, peak = 0;  // bytes, now and the peak
    uint64_t dropped = 0;         // results
    bool frame_waits = false, result_waits = false;
  };
  State state() const;

 private:
  using Lock = std::unique_lock<std::mutex>;

  uint64_t held() const noexcept { return frames_ + results_; }
  bool fits(uint64_t bytes) const noexcept {
    return limit_ == 0 || (held() <= limit_ && bytes <= limit_ - held());
  }
  bool frame_fits(uint64_t bytes) const noexcept { return held() == 0 || fits(bytes); }
  void add(uint64_t* to, uint64_t bytes) noexcept;
  bool drop_oldest(Results& results);
  void release_frame(uint64_t bytes);

  const uint64_t limit_;
  const WhenBusy when_busy_;
  mutable std::mutex mutex_;  // guards the rest
  std::condition_variable changed_;
  uint64_t frames_ = 0, results_ = 0, peak_ = 0, dropped_ = 0;  // bytes; dropped_: results
  size_t frames_waiting_ = 0, results_waiting_ = 0;             // calls
  bool refuses_frames_ = false, refuses_results_ = false;
};

}  // namespace weir::infer
