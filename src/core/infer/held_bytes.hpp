// HeldBytes: the bytes of frames that are in work elsewhere and of results that wait to leave, with
// one bound for both.
//
// A bound never stops a stream: what is alone is taken, however big it is. Every function may be
// called from any thread.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "core/infer/busy_policy.hpp"

namespace weir::infer {

class HeldBytes {
 public:
  // `limit` in bytes, 0 = any. At the bound `when_busy` decides.
  HeldBytes(uint64_t limit, WhenBusy when_busy) : limit_(limit), when_busy_(when_busy) {}
  HeldBytes(const HeldBytes&) = delete;
  HeldBytes& operator=(const HeldBytes&) = delete;
  uint64_t limit() const noexcept { return limit_; }

  // The bytes of a frame, from when it is taken until this ends.
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
  enum class Answer {
    Taken,
    Full,     // it does not fit; only where nobody waits
    Refused,  // from refuse() or refuse_frames() to resume()
  };
  // A frame that comes, which does not wait; the other waits for room where `when_busy` says so.
  static Answer try_frame(const std::shared_ptr<HeldBytes>& held, uint64_t bytes, Share* share);
  static Answer take_frame(const std::shared_ptr<HeldBytes>& held, uint64_t bytes, Share* share);

  // Where results wait. It is asked with the lock of this held, and must not call back.
  class Results {
   public:
    virtual ~Results() = default;
    // Something leaves the queue without the engine's help: who waits gets room.
    virtual bool leave() const = 0;
    // The result that asks would be the next one to leave.
    virtual bool is_next() const = 0;
    // The bytes of the oldest that waits, which is dropped; nullopt: none does.
    virtual std::optional<uint64_t> drop_oldest() = 0;
  };
  enum class Room {
    Taken,
    Dropped,
    Stuck,    // what is held waits for the engine itself, which would wait here
    Refused,  // from refuse() to resume()
  };
  // For a result that an engine gives. Block: waits while others leave. DropOld: in their place.
  Room take_result(uint64_t bytes, Results& results);
  void release_result(uint64_t bytes);
  // Results have left, or have ended: whoever waits asks again.
  void moved();

  // Lets go who waits, and takes nothing until resume().
  void refuse();
  // The same of frames alone: results of those before go on.
  void refuse_frames();
  void resume();

  struct State {
    uint64_t held = 0, most = 0;  // bytes, now and the most at a time
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
  void release_frame(uint64_t bytes);

  const uint64_t limit_;
  const WhenBusy when_busy_;
  mutable std::mutex mutex_;  // guards the rest
  std::condition_variable changed_;
  uint64_t frames_ = 0, results_ = 0, most_ = 0, dropped_ = 0;  // bytes; dropped_: results
  size_t frames_waiting_ = 0, results_waiting_ = 0;             // calls
  bool refuses_frames_ = false, refuses_results_ = false;
};

}  // namespace weir::infer
