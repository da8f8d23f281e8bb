// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/text.hpp"

#include <algorithm>
#include <charconv>
#include <cinttypes>
#include <cmath>
#include <cstdio>

namespace weir {
namespace {

constexpr std::string_view kBlanks = " \t\r\n\f\v";

char lower_char(char c) noexcept {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

// The number of insertions, deletions, replacements and swaps of adjacent letters between two
// words, ignoring case.
size_t edit_distance(std::string_view a, std::string_view b) {
  const auto same = [&](size_t i, size_t j) { return lower_char(a[i]) == lower_char(b[j]); };
  const size_t width = b.size() + 1;
  std::vector<size_t> table((a.size() + 1) * width);
  const auto at = [&](size_t i, size_t j) -> size_t& { return table[i * width + j]; };
  for (size_t i = 0; i <= a.size(); ++i) at(i, 0) = i;
  for (size_t j = 0; j <= b.size(); ++j) at(0, j) = j;
  for (size_t i = 1; i <= a.size(); ++i)
    for (size_t j = 1; j <= b.size(); ++j) {
      at(i, j) = std::min(
          {at(i - 1, j - 1) + (same(i - 1, j - 1) ? 0 : 1), at(i, j - 1) + 1, at(i - 1, j) + 1});
      if (i > 1 && j > 1 && same(i - 1, j - 2) && same(i - 2, j - 1))
        at(i, j) = std::min(at(i, j), at(i - 2, j - 2) + 1);
    }
  return table.back();
}

template <class T>
std::optional<T> parse_whole(std::string_view text) noexcept {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// std::from_chars does not accept a leading plus.
std::string_view without_plus(std::string_view text) noexcept {
  const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-' && text[1] != '+';
  return plus ? text.substr(1) : text;
}

// How many letters two words have in common at their start.
size_t common_prefix(std::string_view a, std::string_view b) noexcept {
  size_t n = 0;
  while (n < std::min(a.size(), b.size()) && equal_ignoring_case(a.substr(n, 1), b.substr(n, 1)))
    ++n;
  return n;
}

}  // namespace

std::string_view strip(std::string_view text) noexcept {
  const size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

std::vector<std::string_view> split(std::string_view text, std::string_view separators,
                                    size_t limit) {
  std::vector<std::string_view> out;
  while (out.size() + 1 < limit) {
    const size_t at = text.find_first_of(separators);
    if (at == std::string_view::npos) break;
    out.push_back(text.substr(0, at));
    text.remove_prefix(at + 1);
  }
  out.push_back(text);
  return out;
}

bool equal_ignoring_case(std::string_view a, std::string_view b) noexcept {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](char x, char y) { return lower_char(x) == lower_char(y); });
}

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(), lower_char);
  return out;
}

std::optional<uint64_t> parse_unsigned(std::string_view text) noexcept {
  return parse_whole<uint64_t>(text);
}

std::optional<int64_t> parse_signed(std::string_view text) noexcept {
  return parse_whole<int64_t>(without_plus(text));
}

std::optional<double> parse_double(std::string_view text) noexcept {
  const auto value = parse_whole<double>(without_plus(text));
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::string nearest(std::string_view word, std::span<const std::string> candidates) {
  std::string best;
  // A word of one letter is near no other.
  size_t best_distance = std::min(std::max<size_t>(1, word.size() / 3) + 1, word.size());
  size_t best_prefix = 0;
  for (const auto& candidate : candidates) {
    const size_t distance = edit_distance(word, candidate);
    const size_t prefix = common_prefix(word, candidate);
    const bool wins_tie = distance == best_distance && !best.empty() && prefix > best_prefix;
    if (distance >= best_distance && !wins_tie) continue;
    best_distance = distance;
    best_prefix = prefix;
    best = candidate;
  }
  return best;
}

std::string time_text(uint64_t nanoseconds) {
  constexpr uint64_t kSecond = 1'000'000'000;
  const uint64_t seconds = nanoseconds / kSecond;
  char text[48];
  std::snprintf(text, sizeof text, "%" PRIu64 ":%02" PRIu64 ":%02" PRIu64 ".%09" PRIu64,
                seconds / 3600, seconds / 60 % 60, seconds % 60, nanoseconds % kSecond);
  return text;
}

}  // namespace weir
