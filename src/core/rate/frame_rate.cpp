// Ticks are counted from the first frame, so that no rounding adds up (specification 6.8).
#include "core/rate/frame_rate.hpp"

#include <algorithm>
#include <string>

#include "core/text/place.hpp"
#include "core/text/text.hpp"

namespace weir {
namespace {

uint64_t apart(uint64_t a, uint64_t b) noexcept {
  return a > b ? a - b : b - a;
}

Error syntax(std::string_view text, size_t place) {
  return Error{Code::OPTION_SYNTAX,
               "framerate cannot be read and is ignored",
               "\"" + std::string(text) + "\"",
               "N/D, two whole numbers from 1 to 2147483647",
               place_in(text, place),
               "framerate=30/1"};
}

std::optional<int> positive(std::string_view text) noexcept {
  const auto value = parse_unsigned(strip(text));
  if (!value || *value < 1 || *value > INT32_MAX) return std::nullopt;
  return static_cast<int>(*value);
}

}  // namespace

Result<std::optional<Fraction>> parse_frame_rate(std::string_view text) {
  if (strip(text).empty()) return std::optional<Fraction>();
  const size_t slash = text.find('/');
  const auto numerator = positive(text.substr(0, slash));
  if (!numerator) return syntax(text, 0);
  if (slash == std::string_view::npos) return syntax(text, text.size());
  const auto denominator = positive(text.substr(slash + 1));
  if (!denominator) return syntax(text, slash + 1);
  return std::optional(Fraction{*numerator, *denominator});
}

uint64_t FrameRate::time_of(uint64_t ticks) const noexcept {
  __extension__ using Wide = unsigned __int128;
  constexpr uint64_t kSecond = 1'000'000'000;
  const Wide time = Wide{ticks} * kSecond * static_cast<uint64_t>(rate_.denominator) /
                    static_cast<uint64_t>(rate_.numerator);
  return static_cast<uint64_t>(std::min(time, Wide{UINT64_MAX / 4}));
}

Tick FrameRate::next() const noexcept {
  const uint64_t begin = time_of(ticks_);
  return {ticks_, base_.value_or(0) + begin, time_of(ticks_ + 1) - begin};
}

Tick FrameRate::take() noexcept {
  const Tick tick = next();
  ++ticks_;
  return tick;
}

std::optional<Tick> FrameRate::take_before(uint64_t behind) noexcept {
  if (!held_ || tie_) return std::nullopt;
  const uint64_t next_time = next().time;
  const uint64_t held = apart(*held_, next_time), other = apart(behind, next_time);
  if (held > other) return std::nullopt;
  tie_ = held == other;
  return take();
}

std::optional<Tick> FrameRate::take_at_end(std::optional<uint64_t> end) noexcept {
  if (!held_) return std::nullopt;
  const uint64_t next_time = next().time;
  if (end ? next_time >= *end : next_time > *held_) return std::nullopt;
  return take();
}

void FrameRate::hold(uint64_t time) noexcept {
  if (!base_) base_ = time;
  held_ = time;
  tie_ = false;
}

}  // namespace weir
