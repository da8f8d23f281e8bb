// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/shell_quote.hpp"

#include <algorithm>

namespace weir {
namespace {

bool is_plain(std::string_view text) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789%+,-./:=@_";
  return !text.empty() && text.find_first_not_of(kPlain) == std::string_view::npos;
}

bool is_control(char c) {
  return static_cast<unsigned char>(c) < ' ' || c == '\x7f';
}

std::string octal(char c) {
  const auto byte = static_cast<unsigned char>(c);
  const auto digit = [](int value) { return static_cast<char>('0' + (value & 7)); };
  return {'\\', digit(byte >> 6), digit(byte >> 3), digit(byte)};
}

// Cuts the text where a C string ends, and so an argument or a property.
std::string_view until_nul(std::string_view text) {
  return text.substr(0, text.find('\0'));
}

// Returns the number of bytes of the UTF-8 character at the begin, 0 if there is none. As GLib, it
// takes neither surrogates nor overlong forms.
size_t character_bytes(std::string_view text) {
  const auto at = [&](size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
  };
  const unsigned first = at(0);
  if (first < 0x80) return 1;
  const size_t bytes = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4) return 0;
  for (size_t i = 1; i < bytes; ++i)
    if ((at(i) & 0xC0) != 0x80) return 0;
  if ((first == 0xE0 && at(1) < 0xA0) || (first == 0xED && at(1) >= 0xA0)) return 0;
  if ((first == 0xF0 && at(1) < 0x90) || (first == 0xF4 && at(1) >= 0x90)) return 0;
  return bytes;
}

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const size_t bytes = character_bytes(text);
    if (bytes == 0) return false;
    text.remove_prefix(bytes);
  }
  return true;
}

// Returns whether GStreamer reads the text as itself between double quotes. It takes a closing
// quote after a backslash for a part of the text, unwraps texts that begin with a quote, and reads
// NULL as none.
bool reads_as_itself(std::string_view text) {
  return !text.starts_with('"') && !text.ends_with('\\') && text != "NULL" && is_utf8(text) &&
         std::none_of(text.begin(), text.end(), is_control);
}

// Writes the text as gst_string_wrap() does: ASCII, between double quotes, which GStreamer unwraps
// when it sets a property.
std::string wrapped(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (is_control(c) || static_cast<unsigned char>(c) >= 0x80)
      out += octal(c);
    else if (is_plain(std::string_view(&c, 1)) &&
             std::string_view("%,=@").find(c) == std::string_view::npos)
      out += c;
    else
      out += std::string("\\") + c;
  }
  return out + "\"";
}

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

std::string shell_word(std::string_view given) {
  const std::string_view text = until_nul(given);
  if (is_plain(text)) return std::string(text);
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'')
      out += "'\\''";
    else if (is_control(c) && c != '\n' && c != '\t')  // would act on the terminal that shows them
      out += "'\"$(printf '" + octal(c) + "')\"'";
    else
      out += c;
  }
  return out + "'";
}

std::string launch_value(std::string_view given) {
  const std::string_view text = until_nul(given);
  if (is_plain(text) && reads_as_itself(text)) return std::string(text);
  std::string quoted = "\"";
  for (const char c : reads_as_itself(text) ? std::string(text) : wrapped(text)) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return shell_word(quoted + "\"");
}

std::string quoted_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : text.substr(0, kQuotedCharacters)) append_quoted(c, &out);
  out += text.size() > kQuotedCharacters ? "...\"" : "\"";
  return out;
}

}  // namespace weir
