// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/error_text.hpp"

#include <algorithm>

#include "core/text/text.hpp"
#include "weir/join.hpp"

namespace weir {
namespace {

constexpr size_t kWhole = 100;  // texts up to this size in bytes are shown whole
constexpr size_t kBefore = 50;  // bytes shown before and after the position in a longer one
constexpr size_t kAfter = 40;

bool begins_character(char c) noexcept {
  return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;
}

size_t characters(std::string_view text) noexcept {
  return static_cast<size_t>(std::count_if(text.begin(), text.end(), begins_character));
}

bool breaks_line(char c) noexcept {
  return c == '\n' || c == '\r' || c == '\t';
}

}  // namespace

std::string place_in(std::string_view text, size_t position) {
  if (text.empty()) return "it is empty";
  position = std::min(position, text.size());
  size_t begin = 0;
  size_t end = text.size();
  if (text.size() > kWhole) {
    begin = position - std::min(position, kBefore);
    end = std::min(text.size(), position + kAfter);
    while (begin > 0 && !begins_character(text[begin])) --begin;
    while (end < text.size() && !begins_character(text[end])) ++end;
  }
  const std::string indent = "    ";
  const std::string before =
      (begin > 0 ? "... " : "") + std::string(text.substr(begin, position - begin));
  std::string line = indent + before + std::string(text.substr(position, end - position)) +
                     (end < text.size() ? " ..." : "");
  std::replace_if(line.begin(), line.end(), breaks_line, ' ');
  const std::string place =
      position == text.size()
          ? "at the end"
          : "at character " + std::to_string(characters(text.substr(0, position)) + 1);
  return place + ":\n" + line + "\n" + indent + std::string(characters(before), ' ') + "^";
}

std::string one_of(std::span<const std::string> words) {
  const std::string out = join(words, ", ");
  return "one of: " + (out.empty() ? "none" : out);
}

Error not_one_of(std::string what, const std::string& offered, std::span<const std::string> words) {
  const std::string close = nearest(offered, words);
  return Error{.code = Code::OPTION_VALUE,
               .what = std::move(what),
               .offered = offered,
               .needed = one_of(words),
               .difference = close.empty() ? "" : "did you mean " + close + "?"};
}

}  // namespace weir
