// Throttle: which frames of a stream are worth an invoke when what stands behind takes fewer
// (specification 4.7). Times are nanoseconds.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>
#include <cstdint>
#include <optional>

namespace weir {

class Throttle {
 public:
  // What is told upstream of a frame that is not taken.
  struct Overflow {
    double proportion;   // how long the frame is, in parts of the delay
    int64_t difference;  // how far the time since the frame last taken is beyond the delay
    bool operator==(const Overflow&) const = default;
  };

  // From any thread: what stands behind takes one frame in `delay` > 0. The least that was heard
  // counts.
  void limit(uint64_t delay) noexcept;
  bool limited() const noexcept { return delay_ != 0; }

  // Streaming thread, once for each frame; nullopt: it is taken. `latency` of an invoke, 0 while it
  // is not known. The first frame is taken; time that goes backwards stands still.
  std::optional<Overflow> refuses(uint64_t time, std::optional<uint64_t> duration,
                                  uint64_t latency) noexcept;

  // After a flush: the next frame is a first one. The limit stays.
  void restart() noexcept;
  // A new stream, without a limit.
  void reset() noexcept;

 private:
  std::atomic<uint64_t> delay_{0};  // 0: every frame is taken
  std::optional<uint64_t> before_;  // time of the frame before, taken or not
  uint64_t accumulated_ = 0;        // since the frame last taken
};

}  // namespace weir
