// Splits a description into tokens like GStreamer's lexer: the longest match wins. Text that
// matches no rule is skipped, so a name after it counts as an element.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/launch_elements.hpp"

#include <algorithm>
#include <cctype>

namespace weir {
namespace {

bool is_blank(char c) {
  return std::isspace(static_cast<unsigned char>(c)) != 0;
}
bool is_alnum(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0;
}
bool begins_identifier(char c) {
  return is_alnum(c) || c == '_';
}
bool is_in_identifier(char c) {
  return begins_identifier(c) || c == '-' || c == '%' || c == ':';
}

// Whether `text` begins with "video/x-raw" or similar, after blanks.
bool begins_with_media_type(std::string_view text) {
  const auto is_media_char = [](char c) { return is_alnum(c) || c == '-'; };
  const auto first = std::find_if_not(text.begin(), text.end(), is_blank);
  const auto slash = std::find_if_not(first, text.end(), is_media_char);
  return slash != first && slash != text.end() && *slash == '/' && slash + 1 != text.end() &&
         is_media_char(slash[1]);
}

// Whether a text between two ! is caps: "video/x-raw,format=RGB; audio/x-raw".
bool is_caps(std::string_view text) {
  if (text.find('\\') != std::string_view::npos) return false;
  while (begins_with_media_type(text)) {
    const size_t end = text.find(';');
    if (end == std::string_view::npos) return true;
    text.remove_prefix(end + 1);
  }
  return false;
}

std::string plain_value(std::string_view value) {
  const bool quoted = value.size() > 1 && (value.front() == '"' || value.front() == '\'') &&
                      value.front() == value.back();
  if (quoted) value = value.substr(1, value.size() - 2);
  std::string out;
  for (size_t i = 0; i < value.size(); ++i) {
    if (value[i] == '\\' && i + 1 < value.size()) ++i;
    out += value[i];
  }
  return out;
}

class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}

  LaunchElements run() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '!')
        link();
      else if (begins_identifier(c))
        name();
      else if (c == '.')
        pad();
      else if (c == ',' && in_pads_)
        skip_blanks(++at_);
      else
        other();
    }
    return std::move(out_);
  }

 private:
  size_t identifier_end(size_t at) const {
    if (at >= text_.size() || !begins_identifier(text_[at])) return at;
    while (at < text_.size() && is_in_identifier(text_[at])) ++at;
    return at;
  }
  size_t blanks_end(size_t at) const {
    while (at < text_.size() && is_blank(text_[at])) ++at;
    return at;
  }
  void skip_blanks(size_t at) { at_ = blanks_end(at); }
  bool has(size_t at, std::string_view part) const { return text_.substr(at).starts_with(part); }

  // The end of a value that begins at `at`: a run without blanks or a quoted text, whichever is
  // longer.
  size_t value_end(size_t at) const {
    size_t run = at;
    while (run < text_.size() && !is_blank(text_[run]))
      run += text_[run] == '\\' && run + 1 < text_.size() && text_[run + 1] != '\n' ? 2 : 1;
    if (at == text_.size() || (text_[at] != '"' && text_[at] != '\'')) return run;
    size_t quoted = at;
    for (size_t i = at + 1; i < text_.size(); ++i) {
      if (text_[i] != text_[at]) continue;
      quoted = i + 1;
      if (text_[i - 1] != '\\') break;
    }
    return std::max(run, quoted);
  }

  void other() {
    if (!is_blank(text_[at_])) in_pads_ = false;
    if (text_[at_] == '(') ++depth_;
    if (text_[at_] == ')' && depth_ > 0) --depth_;
    ++at_;
  }

  void link() {
    in_pads_ = false;
    const size_t end = text_.find('!', ++at_);
    // The ! at the end of caps belongs to the caps.
    if (end != std::string_view::npos && is_caps(text_.substr(at_, end - at_))) at_ = end + 1;
  }

  // ".pad"
  void pad() {
    const size_t end = identifier_end(++at_);
    in_pads_ = end > at_;
    at_ = end;
  }

  void name() {
    if (in_pads_ && follows_comma()) {
      at_ = identifier_end(at_);
      return;
    }
    in_pads_ = false;
    if (uri() || assignment()) return;
    const size_t begin = at_, end = identifier_end(at_), dot = blanks_end(end);
    const auto word = text_.substr(begin, end - begin);
    at_ = end;
    if (has(dot, ".") && has(blanks_end(dot + 1), "(")) {  // "bin.("
      at_ = blanks_end(dot + 1) + 1;
      add(word);
      ++depth_;
    } else if (has(end, ".")) {  // "name." and "name.pad"
      at_ = identifier_end(end + 1);
      in_pads_ = true;
    } else {
      add(word);
    }
  }

  void add(std::string_view factory) {
    out_.factories.emplace_back(factory);
    if (depth_ == 0) out_.outside_bins.emplace_back(factory);
  }

  bool follows_comma() const {
    size_t before = at_;
    while (before > 0 && is_blank(text_[before - 1])) --before;
    return before > 0 && text_[before - 1] == ',';
  }

  // "scheme://rest"
  bool uri() {
    size_t end = at_;
    const auto is_in_scheme = [](char c) { return is_alnum(c) || (c >= '+' && c <= '.'); };
    while (end < text_.size() && is_in_scheme(text_[end])) ++end;
    if (!std::isalpha(static_cast<unsigned char>(text_[at_])) || !has(end, "://")) return false;
    out_.uri_schemes.emplace_back(text_.substr(at_, end - at_));
    at_ = value_end(end + 3);
    return true;
  }

  // "key=value", with blanks around the =.
  bool assignment() {
    const size_t end = identifier_end(at_), equals = blanks_end(end);
    if (!has(equals, "=")) return false;
    const size_t value = blanks_end(equals + 1), value_end_at = value_end(value);
    if (value_end_at == value) return false;
    out_.properties.push_back({out_.factories.empty() ? "" : out_.factories.back(),
                               std::string(text_.substr(at_, end - at_)),
                               plain_value(text_.substr(value, value_end_at - value))});
    at_ = value_end_at;
    return true;
  }

  const std::string_view text_;
  size_t at_ = 0;
  bool in_pads_ = false;  // names after a comma are pads
  size_t depth_ = 0;      // of parentheses
  LaunchElements out_;
};

}  // namespace

LaunchElements launch_elements(std::string_view description) {
  return Scanner(description).run();
}

}  // namespace weir
