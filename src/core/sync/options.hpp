// Options: which policy, as the properties sync-mode and sync-option say; and the call of it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string_view>

#include "core/sync/base_pad.hpp"
#include "core/sync/policy.hpp"
#include "weir/result.hpp"

namespace weir::sync {

enum class Mode { NoSync, Slowest, BasePad, Refresh, Lateness };
std::string_view name_of(Mode mode) noexcept;  // "" of Lateness, which has no word

// "nosync", "slowest", "basepad", "refresh", case ignored; and of the first publication: "base" =
// basepad, and "fastest" = refresh: outputs keep the pace of the fastest pad, and slower ones
// repeat their last frame. MODE_UNKNOWN for another word, with the nearest known one.
Result<Mode> parse_mode(std::string_view text);
// MODE_UNKNOWN, as a note to the user, for a word of the first publication: it is taken.
std::optional<Error> old_word(std::string_view text);

struct Base {
  size_t pad = 0;  // in the order in which pads were requested
  Time duration = kBaseDuration;
};
// "PAD[:DURATION]", nanoseconds; "" = the defaults. OPTION_SYNTAX with the place.
Result<Base> parse_base(std::string_view text);

struct Options {
  Mode mode = Mode::Slowest;
  Base base;       // basepad only
  Stamp lateness;  // Lateness only
};

// Precondition of basepad: options.base.pad < pads.size().
Decision decide(const Options& options, const Round& round, std::span<const PadView> pads);

}  // namespace weir::sync
