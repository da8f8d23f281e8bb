// Counts ticks from the first frame, so that rounding errors do not add up
// (docs/compatibility/routing.md 6.8).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/rate/frame_rate.hpp"

#include <algorithm>
#include <string>

#include "core/text/error_text.hpp"
#include "core/text/text.hpp"

namespace weir {
namespace {

uint64_t apart(uint64_t a, uint64_t b) noexcept {
  return a > b ? a - b : b - a;
}

Error syntax(std::string_view text, size_t place) {
  return Error{.code = Code::OPTION_SYNTAX,
               .what = "framerate cannot be read and is ignored",
               .offered = "\"" + std::string(text) + "\"",
               .needed = "N/D, two whole numbers from 1 to 2147483647",
               .difference = place_in(text, place),
               .fix = "framerate=30/1"};
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

// Nanoseconds of one tick times the rate's numerator.
FrameRate::Wide FrameRate::tick_scale() const noexcept {
  constexpr uint64_t kSecond = 1'000'000'000;
  return Wide{kSecond} * static_cast<uint64_t>(rate_.denominator);
}

FrameRate::Wide FrameRate::get_offset(Wide tick) const noexcept {
  return tick * tick_scale() / numerator();
}

// Precondition: `time` is not before the base.
FrameRate::Wide FrameRate::first_tick_from(uint64_t time) const noexcept {
  const Wide offset = time - base_.value_or(0);
  return (offset * numerator() + tick_scale() - 1) / tick_scale();
}

std::optional<Tick> FrameRate::next() const noexcept {
  const Wide begin = base_.value_or(0) + get_offset(ticks_);
  const Wide end = base_.value_or(0) + get_offset(ticks_ + 1);
  if (begin >= UINT64_MAX) return std::nullopt;
  return Tick{static_cast<uint64_t>(ticks_), static_cast<uint64_t>(begin),
              static_cast<uint64_t>(std::min<Wide>(end, UINT64_MAX) - begin)};
}

Tick FrameRate::skip_to(uint64_t time, Tick first) noexcept {
  const Wide begin = ticks_;
  ticks_ = first_tick_from(time);
  const Wide end = std::min<Wide>(base_.value_or(0) + get_offset(ticks_), UINT64_MAX);
  first.duration = static_cast<uint64_t>(end - first.time);
  first.count = static_cast<uint64_t>(ticks_ - begin);
  first.has_frame = false;
  return first;
}

std::optional<Tick> FrameRate::take_before(uint64_t following, uint64_t max_duplication) noexcept {
  if (!held_ || tie_) return std::nullopt;
  const auto tick = next();
  if (!tick) return std::nullopt;
  const uint64_t held = apart(*held_, tick->time), other = apart(following, tick->time);
  const bool between = tick->time > *held_ && tick->time < following;
  if (between && max_duplication > 0 && std::min(held, other) > max_duplication)
    return skip_to(following - max_duplication, *tick);
  if (held > other) return std::nullopt;
  tie_ = held == other;
  ++ticks_;
  return tick;
}

std::optional<Tick> FrameRate::take_at_end(std::optional<uint64_t> end) noexcept {
  if (!held_) return std::nullopt;
  const auto tick = next();
  if (!tick || (end ? tick->time >= *end : tick->time > *held_)) return std::nullopt;
  ++ticks_;
  return tick;
}

void FrameRate::hold(uint64_t time) noexcept {
  if (!base_) base_ = time;
  held_ = time;
  tie_ = false;
}

}  // namespace weir
