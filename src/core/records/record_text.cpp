// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/records/record_text.hpp"

#include <charconv>
#include <chrono>

#include "weir/label_file.hpp"

namespace weir::records {
namespace {

constexpr int64_t kSecond = 1000000000;

// At least `digits` digits, filled with zeros. Precondition: not negative.
void append_padded(int64_t number, size_t digits, std::string* out) {
  char text[24];
  const auto end = std::to_chars(text, text + sizeof text, number).ptr;
  const auto length = static_cast<size_t>(end - text);
  if (length < digits) out->append(digits - length, '0');
  out->append(text, end);
}

// A fraction of a second without zeros at its end; nothing for 0.
void append_fraction(int64_t nanoseconds, std::string* out) {
  if (nanoseconds == 0) return;
  out->push_back('.');
  append_padded(nanoseconds, 9, out);
  out->erase(out->find_last_not_of('0') + 1);
}

void append_escaped(char c, std::string* out) {
  switch (c) {
    case '"':
      *out += "\\\"";
      break;
    case '\\':
      *out += "\\\\";
      break;
    case '\n':
      *out += "\\n";
      break;
    case '\t':
      *out += "\\t";
      break;
    case '\r':
      *out += "\\r";
      break;
    default:
      append_json_escape({&c, 1}, out);
  }
}

}  // namespace

void append_number(float number, std::string* out) {
  char text[32];
  // Adding 0 turns -0 into 0.
  out->append(text, std::to_chars(text, text + sizeof text, number + 0.0f).ptr);
}

void append_number(int64_t number, std::string* out) {
  char text[24];
  out->append(text, std::to_chars(text, text + sizeof text, number).ptr);
}

void append_seconds(int64_t nanoseconds, std::string* out) {
  if (nanoseconds < 0) out->push_back('-');
  const int64_t sign = nanoseconds < 0 ? -1 : 1;
  append_number(nanoseconds / kSecond * sign, out);
  append_fraction(nanoseconds % kSecond * sign, out);
}

void append_utc(int64_t unix_nanoseconds, std::string* out) {
  using namespace std::chrono;
  const sys_time<nanoseconds> time{nanoseconds(unix_nanoseconds)};
  const auto day = floor<days>(time);
  const year_month_day date{day};
  const hh_mm_ss clock{time - day};
  append_padded(int{date.year()}, 4, out);
  out->push_back('-');
  append_padded(unsigned{date.month()}, 2, out);
  out->push_back('-');
  append_padded(unsigned{date.day()}, 2, out);
  out->push_back('T');
  append_padded(clock.hours().count(), 2, out);
  out->push_back(':');
  append_padded(clock.minutes().count(), 2, out);
  out->push_back(':');
  append_padded(clock.seconds().count(), 2, out);
  append_fraction(clock.subseconds().count(), out);
  out->push_back('Z');
}

void append_json_string(std::string_view text, std::string* out) {
  out->push_back('"');
  while (!text.empty()) {
    const size_t length = utf8_sequence(text);
    if (length == 0)
      *out += "\xEF\xBF\xBD";
    else if (length > 1 && is_terminal_control(text.substr(0, length)))
      append_json_escape(text.substr(0, length), out);
    else if (length > 1 || (text[0] >= ' ' && text[0] != '"' && text[0] != '\\' && text[0] != 0x7F))
      out->append(text.substr(0, length));
    else
      append_escaped(text[0], out);
    text.remove_prefix(std::max<size_t>(length, 1));
  }
  out->push_back('"');
}

}  // namespace weir::records
