// A stream of any rate brought to a fixed one: each tick takes the frame that is nearest in time.
//
// One frame is held until the one behind it is there. Times are nanoseconds.
#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

#include "core/tensor/frame_spec.hpp"

namespace weir {

// "30/1": two whole numbers above 0; nullopt for an empty text. OPTION_SYNTAX with the place.
Result<std::optional<Fraction>> parse_frame_rate(std::string_view text);

// A place of the stream that goes out.
struct Tick {
  uint64_t number = 0;    // from 0
  uint64_t time = 0;      // when it begins
  uint64_t duration = 0;  // until the next one
};

class FrameRate {
 public:
  // `rate` is valid and not 0.
  explicit FrameRate(Fraction rate) noexcept : rate_(rate) {}

  // The next tick takes the held frame and is gone, when no frame behind it can be nearer: with a
  // frame at `behind` ask again until there is none.
  std::optional<Tick> take_before(uint64_t behind) noexcept;
  // At the end: the tick that begins before `end`, or not behind the held frame when `end` is
  // unknown.
  std::optional<Tick> take_at_end(std::optional<uint64_t> end) noexcept;
  // Puts a frame into the place of the held one. The first one's time is that of tick 0. Not before
  // the time that is held.
  void hold(uint64_t time) noexcept;
  std::optional<uint64_t> held() const noexcept { return held_; }
  void reset() noexcept { *this = FrameRate(rate_); }

  Tick next() const noexcept;
  uint64_t interval() const noexcept { return time_of(1); }  // rounded down

 private:
  uint64_t time_of(uint64_t ticks) const noexcept;
  Tick take() noexcept;

  Fraction rate_;
  std::optional<uint64_t> base_, held_;
  uint64_t ticks_ = 0;
  bool tie_ = false;  // the last tick was as near to both frames: the later one takes the next
};

}  // namespace weir
