// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/option_reader.hpp"

#include <algorithm>
#include <utility>

#include "core/text/error_text.hpp"
#include "core/text/text.hpp"

namespace weir::transform {
namespace {

bool is_digit(char c) noexcept {
  return c >= '0' && c <= '9';
}
bool is_letter(char c) noexcept {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

// Index of the first character at or after `from` that is not a digit.
size_t end_of_digits(std::string_view text, size_t from) noexcept {
  while (from < text.size() && is_digit(text[from])) ++from;
  return from;
}

bool has_sign(std::string_view text, size_t at) noexcept {
  return at < text.size() && (text[at] == '+' || text[at] == '-');
}

}  // namespace

bool OptionReader::take(std::string_view word) noexcept {
  if (!equal_ignoring_case(text_.substr(position_, word.size()), word)) return false;
  position_ += word.size();
  return true;
}

ElementType OptionReader::take_type() noexcept {
  size_t letters = position_;
  while (letters < text_.size() && is_letter(text_[letters])) ++letters;
  const size_t digits = end_of_digits(text_, letters) - letters;
  // A name is letters followed by 8, 16, 32 or 64; the caller checks what follows.
  for (size_t length = std::min<size_t>(digits, 2); length >= 1; --length) {
    const size_t end = letters + length;
    const auto type = parse_element_type(text_.substr(position_, end - position_));
    if (type == ElementType::End) continue;
    position_ = end;
    return type;
  }
  return ElementType::End;
}

std::string_view OptionReader::take_digits() noexcept {
  const size_t begin = position_;
  position_ = end_of_digits(text_, begin);
  return text_.substr(begin, position_ - begin);
}

std::string_view OptionReader::take_number() noexcept {
  const size_t begin = position_;
  size_t end = end_of_digits(text_, begin + (has_sign(text_, begin) ? 1 : 0));
  const bool whole = end > begin && is_digit(text_[end - 1]);
  if (end < text_.size() && text_[end] == '.') {
    const size_t fraction = end_of_digits(text_, end + 1);
    if (fraction > end + 1)
      end = fraction;
    else if (!whole)
      return {};
  } else if (!whole) {
    return {};
  }
  if (end < text_.size() && (text_[end] == 'e' || text_[end] == 'E')) {
    const size_t digits = end + 1 + (has_sign(text_, end + 1) ? 1 : 0);
    const size_t exponent = end_of_digits(text_, digits);
    if (exponent > digits) end = exponent;
  }
  position_ = end;
  return text_.substr(begin, end - begin);
}

Error OptionReader::error(Code code, std::string what, std::string needed, std::string fix) const {
  return Error{.code = code,
               .what = std::move(what),
               .offered = "option=" + std::string(text_),
               .needed = std::move(needed),
               .difference = place_in(text_, position_),
               .fix = std::move(fix)};
}

Error OptionReader::syntax_error(std::string needed, std::string fix) const {
  return error(Code::OPTION_SYNTAX, "the option of mode " + std::string(mode_) + " cannot be read",
               std::move(needed), std::move(fix));
}

Error OptionReader::value_error(std::string what, std::string needed, std::string fix) const {
  return error(Code::OPTION_VALUE, std::move(what), std::move(needed), std::move(fix));
}

}  // namespace weir::transform
