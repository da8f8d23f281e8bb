// FrameRate: converts a stream to a fixed rate; each tick takes the frame nearest in time.
//
// Holds one frame until the next one arrives. Times are nanoseconds.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

#include "core/tensor/frame_spec.hpp"

namespace weir {

// "30/1": two integers above 0; nullopt for an empty text. OPTION_SYNTAX with the position.
Result<std::optional<Fraction>> parse_frame_rate(std::string_view text);

// One frame of the output stream, or several consecutive empty ones.
struct Tick {
  uint64_t number = 0;    // starts at 0
  uint64_t time = 0;      // start time
  uint64_t duration = 0;  // until the next tick
  uint64_t count = 1;     // number of ticks; above 1 only if has_frame is false
  bool has_frame = true;  // false: no frame is near enough; downstream gets a GAP event
};

class FrameRate {
 public:
  // Precondition: `rate` is valid and not 0.
  explicit FrameRate(Fraction rate) noexcept : rate_(rate) {}

  // The next tick that takes the held frame, given that the following frame has the time `behind`.
  // Call it until it returns nullopt. A tick takes the nearer frame. Ticks farther than
  // `max_duplication` from both frames are returned as one Tick without a frame; 0 = no limit.
  // Ticks beyond 64 bits do not exist.
  std::optional<Tick> take_before(uint64_t following, uint64_t max_duplication = 0) noexcept;
  // At the end: the next tick before `end` or, if `end` is unknown, not after the held frame.
  std::optional<Tick> take_at_end(std::optional<uint64_t> end) noexcept;
  // Replaces the held frame. The first frame's time is tick 0. Precondition: not earlier than
  // held().
  void hold(uint64_t time) noexcept;
  std::optional<uint64_t> held() const noexcept { return held_; }
  void reset() noexcept { *this = FrameRate(rate_); }

  std::optional<Tick> next() const noexcept;
  uint64_t interval() const noexcept {
    return static_cast<uint64_t>(get_offset(1));
  }  // rounded down

 private:
  __extension__ using Wide = unsigned __int128;

  Wide numerator() const noexcept { return static_cast<uint64_t>(rate_.numerator); }
  Wide tick_scale() const noexcept;
  Wide get_offset(Wide tick) const noexcept;
  Wide first_tick_from(uint64_t time) const noexcept;
  Tick skip_to(uint64_t time, Tick first) noexcept;

  Fraction rate_;
  std::optional<uint64_t> base_, held_;
  Wide ticks_ = 0;
  // The last tick was equally near to both frames: the later one takes the next tick.
  bool tie_ = false;
};

}  // namespace weir
