// A recursive descent parser of the syntax of gst_caps_to_string(), which makes no values.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/caps_syntax.hpp"

#include <algorithm>
#include <cstdint>

#include "core/text/caps_type.hpp"
#include "core/text/shell_quote.hpp"
#include "weir/label_file.hpp"

namespace weir {
namespace {

struct CapsFault {
  Code code = Code::OPTION_SYNTAX;
  size_t at = 0;
  std::string needed{};  // empty: no fault
};

// What is limited for the whole text, with the texts inside it.
struct CapsCounts {
  size_t structures = 0, fields = 0, features = 0;
};

class CapsChecker {
 public:
  CapsChecker(std::string_view text, IsPlainType is_plain_type, size_t depth, CapsCounts* counts)
      : text_(text), is_plain_type_(is_plain_type), depth_(depth), counts_(counts) {}

  // Each function returns whether the text goes on as it should; `fault()` has the reason if not.
  bool caps() {
    do skip_blanks();
    while (at_ < text_.size() && structure(true));
    return fault_.needed.empty();
  }
  bool one_structure() {
    if (!structure(false)) return false;
    skip_blanks();
    return at_ == text_.size() || failed("the end after one structure");
  }
  const CapsFault& fault() const { return fault_; }

 private:
  // A structure to its `;` or the end.
  bool structure(bool may_have_features) {
    if (!counted(&counts_->structures, kMaxCapsStructures, "structures")) return false;
    skip_blanks();
    if (at_ == text_.size() || !is_caps_letter(text_[at_]))
      return failed("a media type, which begins with a letter");
    word();
    skip_blanks();
    if (may_have_features && next('(') && !features()) return false;
    for (skip_blanks(); next(','); skip_blanks())
      if (!field()) return false;
    return at_ == text_.size() || is_at_bracket() || next(';') ||
           failed("a comma, a semicolon or the end");
  }
  // (structure)[ name, field=value ], as gst_caps_to_string() writes structures in structures.
  bool bracketed(CapsType type) {
    if (++depth_ > kMaxCapsDepth) return too_deep();
    ++brackets_;
    do {
      if (!structure(type == CapsType::Caps)) return false;
      skip_blanks();
    } while (type == CapsType::Caps && at_ < text_.size() && !is_at_bracket());
    --brackets_;
    --depth_;
    return next(']') || failed("] after a structure");
  }
  bool features() {
    do {
      if (!counted(&counts_->features, kMaxCapsFeatures, "caps features")) return false;
      skip_blanks();
      const auto name = word();
      const size_t colon = name.find(':');
      const bool is_named =
          colon > 0 && colon + 1 < name.size() && name.find(':', colon + 1) == name.npos;
      const bool is_feature =
          name == "ANY" ||
          (colon != name.npos && is_named &&
           std::all_of(name.begin(), name.begin() + static_cast<int64_t>(colon), is_caps_letter) &&
           std::all_of(name.begin() + static_cast<int64_t>(colon) + 1, name.end(),
                       [](char c) { return is_caps_letter(c) || is_caps_digit(c); }));
      if (!is_feature) return failed("a caps feature such as memory:DMABuf");
      skip_blanks();
    } while (next(','));
    return next(')') || failed(") after the caps features");
  }
  bool field() {
    if (!counted(&counts_->fields, kMaxCapsFields, "fields")) return false;
    skip_blanks();
    if (word().empty()) return failed("the name of a field");
    skip_blanks();
    if (!next('=')) return failed("= after the name of a field");
    return value(CapsType::Guessed);
  }
  bool value(CapsType type) {
    skip_blanks();
    if (next('(') && !cast(&type)) return false;
    skip_blanks();
    if (next('{')) return list(type, '}');
    if (next('<')) return list(type, '>');
    const bool has_structures = type == CapsType::Structure || type == CapsType::Caps;
    if (next('[')) return has_structures ? bracketed(type) : range(type);
    return at_ < text_.size() && text_[at_] == '"' ? quoted(type) : unquoted(type);
  }
  bool cast(CapsType* type) {
    skip_blanks();
    const auto name = word();
    const auto known = caps_type(name);
    if (!known && (name.empty() || !is_plain_type_(std::string(name))))
      return failed("the name of a type that caps have");
    *type = known.value_or(CapsType::Plain);
    skip_blanks();
    return next(')') || failed(") after the name of a type");
  }
  bool list(CapsType type, char end) {
    if (++depth_ > kMaxCapsDepth) return too_deep();
    ++lists_;
    skip_blanks();
    if (!next(end)) {
      do {
        if (!value(type)) return false;
        skip_blanks();
      } while (next(','));
      if (!next(end)) return failed(std::string("a comma or ") + end);
    }
    --lists_;
    --depth_;
    return true;
  }
  bool range(CapsType type) {
    const bool has_ranges = type == CapsType::Guessed || range_type(type) != RangeType::Guessed;
    std::string_view ends[3];
    size_t count = 0;
    const size_t begin = at_;
    do {
      skip_blanks();
      if (count < std::size(ends)) ends[count] = word();
      ++count;
      skip_blanks();
    } while (count < std::size(ends) && next(','));
    if (!next(']')) return failed("] after a range");
    const bool fits =
        has_ranges && count >= 2 && is_range(range_type(type), ends[0], ends[1], ends[2]);
    at_ = fits ? at_ : begin;
    return fits || failed("a range of two numbers, the smaller one first");
  }
  bool unquoted(CapsType type) {
    const size_t begin = at_;
    const auto text = word();
    if (text.empty()) return failed("a value");
    if (type == CapsType::Buffer &&
        (text.size() % 2 != 0 || !std::all_of(text.begin(), text.end(), is_caps_hex_digit)))
      return failed("bytes in hexadecimal");
    if (type == CapsType::List) return failed("a list");
    if (type == CapsType::Structure || type == CapsType::Caps) return nested(type, text, begin);
    return lists_ == 0 || is_value(type, text) || failed("values of the type of their list");
  }
  bool quoted(CapsType type) {
    const size_t begin = at_++;
    std::string text;
    bool has_number = false;  // \NNN, which some of GStreamer's types read as a byte
    while (at_ < text_.size() && text_[at_] != '"') {
      if (text_[at_] == '\\' && ++at_ < text_.size())
        has_number = has_number || is_caps_digit(text_[at_]);
      if (at_ < text_.size()) text += text_[at_++];
    }
    if (!next('"')) return failed("a quotation mark at the end of a value");
    if (type == CapsType::Buffer || type == CapsType::List)
      return failed("a value without quotation marks");
    if (type != CapsType::Structure && type != CapsType::Caps)
      return lists_ == 0 || type == CapsType::Guessed ||
             (type == CapsType::Text &&
              (!has_number || is_text(decoded(text_.substr(begin, at_ - begin))))) ||
             failed("values of the type of their list");
    at_ = has_number ? begin : at_;
    return has_number ? failed("a structure without \\NNN") : nested(type, text, begin);
  }
  // The bytes of a text in quotes, where \NNN is a byte.
  static std::string decoded(std::string_view quoted) {
    std::string out;
    for (size_t i = 0; i < quoted.size(); ++i) {
      if (quoted[i] == '\\' && i + 3 < quoted.size() && is_caps_digit(quoted[i + 1])) {
        out += static_cast<char>((quoted[i + 1] - '0') * 64 + (quoted[i + 2] - '0') * 8 +
                                 (quoted[i + 3] - '0'));
        i += 3;
      } else if (quoted[i] == '\\') {
        out += quoted[++i];
      } else {
        out += quoted[i];
      }
    }
    return out;
  }
  bool nested(CapsType type, std::string_view text, size_t begin) {
    if (depth_ + 1 > kMaxCapsDepth) return too_deep();
    CapsChecker inner(text, is_plain_type_, depth_ + 1, counts_);
    inner.lists_ = lists_;
    if (type == CapsType::Caps ? inner.caps() : inner.one_structure()) return true;
    fault_ = inner.fault();
    fault_.at = begin;
    return false;
  }

  bool is_at_bracket() const { return brackets_ > 0 && at_ < text_.size() && text_[at_] == ']'; }
  bool next(char c) {
    if (at_ == text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  void skip_blanks() {
    while (at_ < text_.size() && is_caps_blank(text_[at_])) ++at_;
  }
  std::string_view word() {
    const size_t begin = at_;
    while (at_ < text_.size() && is_caps_word(text_[at_])) ++at_;
    return text_.substr(begin, at_ - begin);
  }
  bool failed(std::string needed) {
    fault_ = CapsFault{Code::OPTION_SYNTAX, at_, std::move(needed)};
    return false;
  }
  bool counted(size_t* count, size_t max, const char* what) {
    if (++*count <= max) return true;
    fault_ = CapsFault{Code::LIMIT_EXCEEDED, at_, "at most " + std::to_string(max) + " " + what};
    return false;
  }
  bool too_deep() {
    fault_ = CapsFault{
        Code::LIMIT_EXCEEDED, at_,
        "at most " + std::to_string(kMaxCapsDepth) + " lists or structures in each other"};
    return false;
  }

  std::string_view text_;
  IsPlainType is_plain_type_;
  size_t depth_, at_ = 0;
  // Open lists. GStreamer 1.22 leaks the values of a list that has one that cannot be read.
  size_t lists_ = 0;
  size_t brackets_ = 0;  // structures in brackets that are open
  CapsCounts* counts_;
  CapsFault fault_;
};

Status check_text(std::string_view text, IsPlainType is_plain_type, bool is_caps) {
  CapsCounts counts;
  CapsChecker checker(text, is_plain_type, 0, &counts);
  CapsFault fault;
  if (text.size() > kMaxCapsBytes)
    fault = CapsFault{Code::LIMIT_EXCEEDED, kMaxCapsBytes,
                      "at most " + std::to_string(kMaxCapsBytes) + " bytes"};
  else if (!is_text(text))
    fault = CapsFault{Code::OPTION_SYNTAX, 0, "text in UTF-8"};
  else if (!(is_caps ? checker.caps() : checker.one_structure()))
    fault = checker.fault();
  if (fault.needed.empty()) return ok();
  return Error{.code = fault.code,
               .what = is_caps ? "the text of caps cannot be used"
                               : "the text of a structure cannot be used",
               .offered = quoted_text(text) + ", " + std::to_string(text.size()) + " bytes",
               .needed = fault.needed,
               .difference = "at byte " + std::to_string(fault.at),
               .fix = is_caps ? "write caps as gst_caps_to_string() does"
                              : "write a structure as gst_structure_to_string() does"};
}

}  // namespace

Status check_caps_text(std::string_view text, IsPlainType is_plain_type) {
  return check_text(text, is_plain_type, true);
}

Status check_structure_text(std::string_view text, IsPlainType is_plain_type) {
  return check_text(text, is_plain_type, false);
}

}  // namespace weir
