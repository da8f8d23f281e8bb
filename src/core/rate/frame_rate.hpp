// A stream of any rate brought to a fixed one: each tick takes the frame that is nearest in time.
//
// One frame is held until the one behind it is there. Times are nanoseconds.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

#include "core/tensor/frame_spec.hpp"

namespace weir {

// "30/1": two whole numbers above 0; nullopt for an empty text. OPTION_SYNTAX with the place.
Result<std::optional<Fraction>> parse_frame_rate(std::string_view text);

// One frame of the output stream, or several consecutive ones that stay empty.
struct Tick {
  uint64_t number = 0;    // from 0
  uint64_t time = 0;      // start time
  uint64_t duration = 0;  // until the next tick
  uint64_t count = 1;     // of ticks; more than 1 only where has_frame is false
  bool has_frame = true;  // false: no frame is near enough, downstream gets a GAP event
};

class FrameRate {
 public:
  // `rate` is valid and not 0.
  explicit FrameRate(Fraction rate) noexcept : rate_(rate) {}

  // The next tick that belongs to the held frame, when the following frame has the time `behind`.
  // Call it until it returns nothing. A tick takes the frame that is nearer in time. Ticks that are
  // farther than `max_duplication` from both frames come as one Tick without a frame; 0 = no limit.
  // Ticks whose time is beyond 64 bits do not exist.
  std::optional<Tick> take_before(uint64_t behind, uint64_t max_duplication = 0) noexcept;
  // At the end: the tick that begins before `end`, or not behind the held frame when `end` is
  // unknown.
  std::optional<Tick> take_at_end(std::optional<uint64_t> end) noexcept;
  // Puts a frame into the place of the held one. The first one's time is that of tick 0. Not before
  // the time that is held.
  void hold(uint64_t time) noexcept;
  std::optional<uint64_t> held() const noexcept { return held_; }
  void reset() noexcept { *this = FrameRate(rate_); }

  std::optional<Tick> next() const noexcept;
  uint64_t interval() const noexcept {
    return static_cast<uint64_t>(offset_of(1));
  }  // rounded down

 private:
  __extension__ using Wide = unsigned __int128;

  Wide numerator() const noexcept { return static_cast<uint64_t>(rate_.numerator); }
  Wide tick_scale() const noexcept;
  Wide offset_of(Wide tick) const noexcept;
  Wide first_tick_from(uint64_t time) const noexcept;
  Tick skip_to(uint64_t time, Tick first) noexcept;

  Fraction rate_;
  std::optional<uint64_t> base_, held_;
  Wide ticks_ = 0;
  bool tie_ = false;  // the last tick was as near to both frames: the later one takes the next
};

}  // namespace weir
