// A recursive descent parser of the syntax of gst_caps_to_string(), which makes no values.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/caps_syntax.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>

#include "core/text/caps_range.hpp"
#include "core/text/quoted.hpp"
#include "weir/label_file.hpp"

namespace weir {
namespace {

enum class CapsType { Guessed, Int, Int64, Double, Fraction, Buffer, List, Structure, Caps, Plain };

struct NamedCapsType {
  std::string_view name;
  CapsType type;
};
// The abbreviations and names that GStreamer knows.
constexpr NamedCapsType kCapsTypes[] = {
    {"int", CapsType::Int},
    {"i", CapsType::Int},
    {"gint", CapsType::Int},
    {"int64", CapsType::Int64},
    {"gint64", CapsType::Int64},
    {"double", CapsType::Double},
    {"d", CapsType::Double},
    {"gdouble", CapsType::Double},
    {"fraction", CapsType::Fraction},
    {"GstFraction", CapsType::Fraction},
    {"buffer", CapsType::Buffer},
    {"GstBuffer", CapsType::Buffer},
    {"list", CapsType::List},
    {"GstValueList", CapsType::List},
    {"array", CapsType::List},
    {"GstValueArray", CapsType::List},
    {"structure", CapsType::Structure},
    {"GstStructure", CapsType::Structure},
    {"GstCaps", CapsType::Caps},
    {"uint", CapsType::Plain},
    {"u", CapsType::Plain},
    {"guint", CapsType::Plain},
    {"uint64", CapsType::Plain},
    {"guint64", CapsType::Plain},
    {"float", CapsType::Plain},
    {"f", CapsType::Plain},
    {"gfloat", CapsType::Plain},
    {"boolean", CapsType::Plain},
    {"bool", CapsType::Plain},
    {"b", CapsType::Plain},
    {"gboolean", CapsType::Plain},
    {"string", CapsType::Plain},
    {"str", CapsType::Plain},
    {"s", CapsType::Plain},
    {"gchararray", CapsType::Plain},
    {"bitmask", CapsType::Plain},
    {"GstBitmask", CapsType::Plain},
    {"flagset", CapsType::Plain},
    {"GstFlagSet", CapsType::Plain},
};

constexpr bool is_caps_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}
constexpr bool is_caps_digit(char c) {
  return c >= '0' && c <= '9';
}
constexpr bool is_caps_hex_digit(char c) {
  return is_caps_digit(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F');
}
constexpr bool is_caps_blank(char c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}
// In a value without quotes.
constexpr bool is_caps_word(char c) {
  return is_caps_letter(c) || is_caps_digit(c) ||
         std::string_view("_-+/:.").find(c) != std::string_view::npos;
}

RangeType range_type(CapsType type) {
  switch (type) {
    case CapsType::Int:
      return RangeType::Int;
    case CapsType::Int64:
      return RangeType::Int64;
    case CapsType::Double:
      return RangeType::Double;
    case CapsType::Fraction:
      return RangeType::Fraction;
    default:
      return RangeType::Guessed;
  }
}

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

  // Each function returns whether the text goes on as it should; `fault()` says why not.
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
    if (!counted(&counts_->structures, kMostCapsStructures, "structures")) return false;
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
    if (++depth_ > kMostCapsDepth) return too_deep();
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
      if (!counted(&counts_->features, kMostCapsFeatures, "caps features")) return false;
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
    if (!counted(&counts_->fields, kMostCapsFields, "fields")) return false;
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
    const auto* known = std::find_if(std::begin(kCapsTypes), std::end(kCapsTypes),
                                     [name](const NamedCapsType& t) { return t.name == name; });
    if (known == std::end(kCapsTypes) && (name.empty() || !is_plain_type_(std::string(name))))
      return failed("the name of a type that caps have");
    *type = known == std::end(kCapsTypes) ? CapsType::Plain : known->type;
    skip_blanks();
    return next(')') || failed(") after the name of a type");
  }
  bool list(CapsType type, char end) {
    if (++depth_ > kMostCapsDepth) return too_deep();
    skip_blanks();
    if (!next(end)) {
      do {
        if (!value(type)) return false;
        skip_blanks();
      } while (next(','));
      if (!next(end)) return failed(std::string("a comma or ") + end);
    }
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
    return (type != CapsType::Structure && type != CapsType::Caps) || nested(type, text, begin);
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
    if (type != CapsType::Structure && type != CapsType::Caps) return true;
    at_ = has_number ? begin : at_;
    return has_number ? failed("a structure without \\NNN") : nested(type, text, begin);
  }
  bool nested(CapsType type, std::string_view text, size_t begin) {
    if (depth_ + 1 > kMostCapsDepth) return too_deep();
    CapsChecker inner(text, is_plain_type_, depth_ + 1, counts_);
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
  bool counted(size_t* count, size_t most, const char* what) {
    if (++*count <= most) return true;
    fault_ = CapsFault{Code::LIMIT_EXCEEDED, at_, "at most " + std::to_string(most) + " " + what};
    return false;
  }
  bool too_deep() {
    fault_ = CapsFault{
        Code::LIMIT_EXCEEDED, at_,
        "at most " + std::to_string(kMostCapsDepth) + " lists or structures in each other"};
    return false;
  }

  std::string_view text_;
  IsPlainType is_plain_type_;
  size_t depth_, at_ = 0;
  size_t brackets_ = 0;  // structures in brackets that are open
  CapsCounts* counts_;
  CapsFault fault_;
};

Status check_text(std::string_view text, IsPlainType is_plain_type, bool is_caps) {
  CapsCounts counts;
  CapsChecker checker(text, is_plain_type, 0, &counts);
  CapsFault fault;
  if (text.size() > kMostCapsBytes)
    fault = CapsFault{Code::LIMIT_EXCEEDED, kMostCapsBytes,
                      "at most " + std::to_string(kMostCapsBytes) + " bytes"};
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
