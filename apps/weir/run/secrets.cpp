// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/secrets.hpp"

#include <algorithm>
#include <array>

namespace weir::app {
namespace {

constexpr std::array<std::string_view, 6> kNames{"password", "passwd", "passphrase",
                                                 "secret",   "token",  "-pw"};
constexpr char kHidden[] = "***";

// "rtsp://user:password@camera" becomes "rtsp://***@camera".
std::string without_logins(const std::string& text) {
  constexpr std::string_view kBegin = "://", kEnd = "/@\"' \t\n";
  std::string out;
  size_t done = 0;
  for (size_t at = text.find(kBegin); at != std::string::npos; at = text.find(kBegin, done)) {
    const size_t login = at + kBegin.size();
    const size_t end = text.find_first_of(kEnd, login);
    out.append(text, done, login - done);
    done = login;
    if (end == std::string::npos || text[end] != '@' || end == login) continue;
    out += kHidden;
    done = end;
  }
  return out.append(text, done);
}

// Where the value of "NAME = value" or "NAME:value" begins, if `at` is after the name; else npos.
size_t value_at(const std::string& text, size_t at) {
  const auto skip_blanks = [&text](size_t from) {
    return std::min(text.find_first_not_of(' ', from), text.size());
  };
  at = skip_blanks(at);
  if (at == text.size() || (text[at] != '=' && text[at] != ':')) return std::string::npos;
  return skip_blanks(at + 1);
}

size_t end_of_value(const std::string& text, size_t at) {
  const char quote = at < text.size() ? text[at] : '\0';
  if (quote != '"' && quote != '\'')
    return std::min(text.find_first_of(" ,!\t\n", at), text.size());
  const size_t end = text.find(quote, at + 1);
  return end == std::string::npos ? text.size() : end + 1;
}

}  // namespace

bool is_secret(std::string_view property) {
  return std::any_of(kNames.begin(), kNames.end(),
                     [property](std::string_view name) { return property.ends_with(name); });
}

std::string without_secrets(const std::string& whole) {
  std::string text = without_logins(whole);
  for (const std::string_view name : kNames)
    for (size_t at = text.find(name); at != std::string::npos; at = text.find(name, at)) {
      at += name.size();
      const size_t value = value_at(text, at);
      if (value == std::string::npos || value == text.size()) continue;
      text.replace(value, end_of_value(text, value) - value, kHidden);
      at = value;
    }
  return text;
}

}  // namespace weir::app
