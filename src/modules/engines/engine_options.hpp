// The options of an engine: keys without regard to case, values checked, unknown ones reported.
#pragma once
#include <charconv>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "module_host.hpp"

namespace weir::engine {

inline bool same_word(std::string_view a, std::string_view b) {
  const auto low = [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  };
  if (a.size() != b.size()) return false;
  for (size_t i = 0; i < a.size(); ++i)
    if (low(a[i]) != low(b[i])) return false;
  return true;
}

inline std::string_view text_or_empty(const char* text) {
  return text ? text : "";
}

// A whole number of at least `least`: OPTION_VALUE otherwise.
inline Result<int> number_option(std::string_view key, std::string_view text, int least) {
  int value = 0;
  const auto [end, bad] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (bad == std::errc{} && end == text.data() + text.size() && value >= least) return value;
  const std::string name(key);
  return Error{Code::OPTION_VALUE,
               "the option " + name + " has a value that cannot be used",
               name + ":" + std::string(text),
               "a whole number, at least " + std::to_string(least),
               "",
               "custom=" + name + ":" + std::to_string(least < 1 ? 1 : least)};
}

// true/false, 1/0, yes/no, on/off: OPTION_VALUE otherwise.
inline Result<bool> switch_option(std::string_view key, std::string_view text) {
  for (const auto word : {"true", "1", "yes", "on"})
    if (same_word(text, word)) return true;
  for (const auto word : {"false", "0", "no", "off"})
    if (same_word(text, word)) return false;
  const std::string name(key);
  return Error{Code::OPTION_VALUE,
               "the option " + name + " has a value that cannot be used",
               name + ":" + std::string(text),
               "true or false",
               "",
               "custom=" + name + ":true"};
}

inline void warn_unknown_option(std::string_view key, std::string_view known) {
  log(WEIR_LOG_WARNING, "the option " + std::string(key) +
                            " is not known and is ignored; known: " + std::string(known));
}

}  // namespace weir::engine
