// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/dataset/file_pattern.hpp"

#include "core/text/error_text.hpp"

namespace weir::dataset {
namespace {

constexpr size_t kMaxWidth = 32;

Error bad_pattern(std::string_view text, std::string what, size_t position) {
  return Error{.code = Code::OPTION_SYNTAX,
               .what = "the pattern of the file names cannot be used: " + std::move(what),
               .offered = "location=" + std::string(text),
               .needed = "one number of the file, such as %d or %04d; %% is a percent sign",
               .difference = place_in(text, position),
               .fix = "location=sample_%04d.png"};
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

// A conversion of printf after its percent sign.
struct Number {
  char fill = ' ';
  size_t width = 0;
  size_t length = 0;  // characters of the text
  const char* fault = nullptr;
};

Number read_number(std::string_view text) {
  Number out;
  if (!text.empty() && text[0] == '0') out.fill = '0';
  for (; out.length < text.size() && is_digit(text[out.length]); ++out.length) {
    out.width = out.width * 10 + static_cast<size_t>(text[out.length] - '0');
    if (out.width > kMaxWidth) {
      out.fault = "its number is too wide";
      return out;
    }
  }
  const auto kind = text.substr(out.length++, 1);
  if (kind != "d" && kind != "i" && kind != "u") out.fault = "it has an unknown conversion";
  return out;
}

}  // namespace

Result<FilePattern> FilePattern::parse(std::string_view text) {
  FilePattern out;
  std::string* part = &out.before_;
  for (size_t at = 0; at < text.size(); ++at) {
    if (text[at] != '%') {
      *part += text[at];
      continue;
    }
    if (text.substr(at, 2) == "%%") {
      *part += text[at++];
      continue;
    }
    if (part == &out.after_) return bad_pattern(text, "it has a second number", at);
    const Number number = read_number(text.substr(at + 1));
    if (number.fault) return bad_pattern(text, number.fault, at);
    out.fill_ = number.fill;
    out.width_ = number.width;
    part = &out.after_;
    at += number.length;
  }
  if (part == &out.before_) return bad_pattern(text, "it has no number", text.size());
  return out;
}

std::string FilePattern::name(uint64_t index) const {
  const std::string digits = std::to_string(index);
  const size_t missing = width_ > digits.size() ? width_ - digits.size() : 0;
  return before_ + std::string(missing, fill_) + digits + after_;
}

}  // namespace weir::dataset
