// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/sync/options.hpp"

#include <array>
#include <string>

#include "core/sync/policies.hpp"
#include "core/text/error_text.hpp"
#include "core/text/text.hpp"

namespace weir::sync {
namespace {

struct ModeName {
  const char* text;
  Mode mode;
  bool old = false;  // a name of the first publication
};
constexpr std::array kModeNames{
    ModeName{"nosync", Mode::NoSync},      ModeName{"slowest", Mode::Slowest},
    ModeName{"basepad", Mode::BasePad},    ModeName{"refresh", Mode::Refresh},
    ModeName{"base", Mode::BasePad, true}, ModeName{"fastest", Mode::Refresh, true}};

Error bad_option(std::string_view text, size_t place, const char* needed) {
  return Error{.code = Code::OPTION_SYNTAX,
               .what = "sync-option cannot be read",
               .offered = std::string(text),
               .needed = needed,
               .difference = place_in(text, place),
               .fix = "sync-mode=basepad sync-option=0:33333333"};
}

}  // namespace

std::string_view to_string(Mode mode) noexcept {
  for (const ModeName& name : kModeNames)
    if (name.mode == mode) return name.text;
  return "";
}

Result<Mode> parse_mode(std::string_view text) {
  const std::string_view wanted = strip(text);
  for (const ModeName& name : kModeNames)
    if (equal_ignoring_case(name.text, wanted)) return name.mode;
  std::vector<std::string> known;
  known.reserve(std::size(kModeNames));
  for (const ModeName& name : kModeNames) known.emplace_back(name.text);
  const std::string near = nearest(lower(wanted), known);
  return Error{.code = Code::MODE_UNKNOWN,
               .what = "sync-mode is unknown",
               .offered = std::string(text),
               .needed = "nosync, slowest, basepad or refresh",
               .fix = near.empty() ? "" : "sync-mode=" + near};
}

std::optional<Error> old_name_warning(std::string_view text) {
  for (const ModeName& name : kModeNames)
    if (name.old && equal_ignoring_case(name.text, strip(text)))
      return Error{.code = Code::MODE_UNKNOWN,
                   .what = "sync-mode=" + std::string(name.text) +
                           " is an old name that NNStreamer 2.7 does not know; it is read as " +
                           std::string(to_string(name.mode)),
                   .offered = std::string(text),
                   .needed = "nosync, slowest, basepad or refresh",
                   .fix = "sync-mode=" + std::string(to_string(name.mode))};
  return std::nullopt;
}

Result<Base> parse_base(std::string_view text) {
  Base out;
  if (strip(text).empty()) return out;
  const auto parts = split(text, ":", 2);
  const auto pad = parse_unsigned(strip(parts[0]));
  if (!pad) return bad_option(text, 0, "PAD or PAD:DURATION, PAD from 0, DURATION in nanoseconds");
  out.pad = static_cast<size_t>(*pad);
  if (parts.size() == 1) return out;
  const auto duration = parse_unsigned(strip(parts[1]));
  if (!duration)
    return bad_option(text, parts[0].size() + 1, "a number of nanoseconds after the colon");
  out.duration = *duration;
  return out;
}

Decision decide(const Options& options, const Round& round, std::span<const PadView> pads) {
  switch (options.mode) {
    case Mode::NoSync:
      return decide_no_sync(round, pads);
    case Mode::Slowest:
      return decide_slowest(round, pads);
    case Mode::BasePad:
      return decide_base_pad(round, pads, options.base.pad, options.base.duration);
    case Mode::Refresh:
      return decide_refresh(round, pads);
    case Mode::Lateness:
      break;
  }
  return decide_lateness(round, pads, options.lateness);
}

}  // namespace weir::sync
