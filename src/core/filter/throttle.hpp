// Throttle: selects the frames to invoke when the downstream element accepts fewer frames
// (docs/compatibility/filter.md 4.7). Times are nanoseconds.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>
#include <cstdint>
#include <optional>

namespace weir {

class Throttle {
 public:
  // The values of the QoS event that is sent upstream for a dropped frame.
  struct Overflow {
    double proportion;   // the frame's duration divided by the delay
    int64_t difference;  // the time since the last accepted frame, minus the delay
    bool operator==(const Overflow&) const = default;
  };

  // Any thread: the downstream element accepts one frame per `delay` > 0. The smallest delay so far
  // applies.
  void limit(uint64_t delay) noexcept;
  bool limited() const noexcept { return delay_ != 0; }

  // Streaming thread, once for each frame. Returns nullopt if the frame is accepted. `latency` of
  // an invoke is 0 while unknown. Accepts the first frame; timestamps that go backwards count as no
  // time.
  std::optional<Overflow> refuses(uint64_t time, std::optional<uint64_t> duration,
                                  uint64_t latency) noexcept;

  // After a flush: treats the next frame as the first one. Keeps the limit.
  void restart() noexcept;
  // For a new stream: removes the limit.
  void reset() noexcept;

 private:
  std::atomic<uint64_t> delay_{0};  // 0: every frame is accepted
  std::optional<uint64_t> before_;  // time of the previous frame, accepted or not
  uint64_t accumulated_ = 0;        // since the last accepted frame
};

}  // namespace weir
