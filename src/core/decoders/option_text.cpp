// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/decoders/option_text.hpp"
#include "core/tensor/geometry.hpp"

#include "core/text/text.hpp"

namespace weir::decoders {
namespace {

constexpr uint64_t kMaxSide = 32767;  // pixels

}  // namespace

Size read_size(const Options& options, const char* option, const char* meaning) {
  const std::string text(options.get(option).value_or(""));
  const auto failure = [&](Code code, const char* what) {
    return Failure({.code = code,
                    .what = std::string(option) + " " + what,
                    .offered = text.empty() ? "no " + std::string(option) : option + ("=" + text),
                    .needed = std::string(meaning) + " as WIDTH:HEIGHT, each from 1 to " +
                              std::to_string(kMaxSide),
                    .fix = std::string(option) + "=640:480"});
  };
  if (text.empty()) throw failure(Code::OPTION_VALUE, "is required");
  const auto parts = split(text, ":");
  if (parts.size() != 2) throw failure(Code::OPTION_SYNTAX, "is not a size");
  const auto width = parse_unsigned(strip(parts[0])), height = parse_unsigned(strip(parts[1]));
  if (!width || !height) throw failure(Code::OPTION_SYNTAX, "is not a size");
  const auto fits = [](uint64_t side) { return side > 0 && side <= kMaxSide; };
  if (!fits(*width) || !fits(*height))
    throw failure(Code::OPTION_VALUE, "is a size that cannot be used");
  return {static_cast<uint32_t>(*width), static_cast<uint32_t>(*height)};
}

bool read_switch(const Options& options, const char* option) {
  const std::string_view text = strip(options.get(option).value_or(""));
  if (text.empty() || text == "0") return false;
  if (text == "1") return true;
  throw Failure({.code = Code::OPTION_VALUE,
                 .what = std::string(option) + " is neither on nor off",
                 .offered = option + ("=" + std::string(text)),
                 .needed = "0 for off or 1 for on",
                 .fix = std::string(option) + "=1"});
}

}  // namespace weir::decoders
