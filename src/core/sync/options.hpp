// Options: the sync policy selected by the properties sync-mode and sync-option, and its
// invocation.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string_view>

#include "core/sync/policies.hpp"
#include "weir/result.hpp"

namespace weir::sync {

enum class Mode { NoSync, Slowest, BasePad, Refresh, Lateness };
std::string_view to_string(Mode mode) noexcept;  // "" for Lateness, which has no name

// "nosync", "slowest", "basepad" or "refresh", in any case. Also the names of the first
// publication: "base" = basepad, and "fastest" = refresh (outputs at the pace of the fastest pad;
// slower pads repeat their last frame). MODE_UNKNOWN for other names, with the nearest known one.
Result<Mode> parse_mode(std::string_view text);
// A note with MODE_UNKNOWN for a name of the first publication, which parse_mode() accepts.
std::optional<Error> old_name_warning(std::string_view text);

struct Base {
  size_t pad = 0;  // in the order in which pads were requested
  Time duration = kBaseDuration;
};
// "PAD[:DURATION]", nanoseconds; "" = the defaults. OPTION_SYNTAX with the position.
Result<Base> parse_base(std::string_view text);

struct Options {
  Mode mode = Mode::Slowest;
  Base base;       // basepad only
  Stamp lateness;  // Lateness only
};

// Precondition for basepad: options.base.pad < pads.size().
Decision decide(const Options& options, const Round& round, std::span<const PadView> pads);

}  // namespace weir::sync
