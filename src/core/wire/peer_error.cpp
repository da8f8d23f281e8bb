// Errors about bytes that a peer sent.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/wire/peer_error.hpp"

#include <utility>

namespace weir::wire {
namespace {

constexpr size_t kQuotedCharacters = 64;

void append_quoted(char c, std::string* out) {
  constexpr char kDigits[] = "0123456789abcdef";
  const auto value = static_cast<unsigned char>(c);
  if (value >= ' ' && value < 0x7F) {
    *out += c;
  } else {
    *out += "\\x";
    *out += kDigits[value >> 4];
    *out += kDigits[value & 0xF];
  }
}

}  // namespace

Error peer_error(std::string what, std::string offered, std::string needed, std::string fix) {
  if (fix.empty()) fix = "check the address, and which program and version runs there";
  return {.code = Code::PEER_MESSAGE_INVALID,
          .what = std::move(what),
          .offered = std::move(offered),
          .needed = std::move(needed),
          .fix = std::move(fix)};
}

std::string quoted_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : text.substr(0, kQuotedCharacters)) append_quoted(c, &out);
  out += text.size() > kQuotedCharacters ? "...\"" : "\"";
  return out;
}

}  // namespace weir::wire
