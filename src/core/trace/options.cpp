// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/options.hpp"

#include <array>

#include "core/text/text.hpp"

namespace weir::trace {
namespace {

constexpr std::string_view kFix = "file=trace.json,limit=1000000";

Error refused(std::string_view part, const std::string& needed, const std::string& fix) {
  return {.code = Code::OPTION_SYNTAX,
          .what = "an option of the tracer weir cannot be read",
          .offered = std::string(part),
          .needed = needed,
          .fix = "GST_TRACERS=\"weir(" + fix + ")\""};
}

Error unknown(std::string_view part, std::string_view key, std::string_view value) {
  const std::array<std::string, 2> known{"file", "limit"};
  const std::string guess = nearest(key, known);
  return refused(part, "file=PATH or limit=NUMBER",
                 guess.empty() ? std::string(kFix) : guess + "=" + std::string(value));
}

}  // namespace

Result<Options> read_options(std::string_view text) {
  Options out;
  if (strip(text).empty()) return out;
  for (const std::string_view part : split(text, ",")) {
    const auto words = split(part, "=", 2);
    const std::string_view key = strip(words[0]);
    const std::string_view value = words.size() > 1 ? strip(words[1]) : std::string_view();
    if (key == "file" && words.size() > 1) {
      out.file = value;
    } else if (key == "limit") {
      const auto limit = parse_unsigned(value);
      if (!limit || *limit == 0 || *limit > size_t{1} << 40)
        return refused(strip(part), "limit= with a number of records, at least 1",
                       std::string(kFix));
      out.limit = static_cast<size_t>(*limit);
    } else {
      return unknown(strip(part), key, value);
    }
  }
  return out;
}

}  // namespace weir::trace
