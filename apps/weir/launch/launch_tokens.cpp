// Splits the text; blanks around = belong to the word.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "launch/launch_tokens.hpp"

#include <cctype>

#include "core/text/error_text.hpp"

namespace weir::app {
namespace {

bool blank(char c) {
  return std::isspace(static_cast<unsigned char>(c)) != 0;
}

class Cutter {
 public:
  explicit Cutter(std::string_view text) : text_(text) {}

  Result<std::vector<LaunchToken>> run() {
    while (skip_blanks()) {
      tokens_.push_back({"", at_, false});
      if (auto status = read_token(&tokens_.back()); !status) return status.error();
    }
    return std::move(tokens_);
  }

 private:
  bool skip_blanks() {
    while (at_ < text_.size() && blank(text_[at_])) ++at_;
    return at_ < text_.size();
  }
  // Whether the word continues after blanks: a = follows or precedes them.
  bool goes_on() {
    const size_t before = at_;
    const bool after_equals = text_[at_ - 1] == '=';
    if (skip_blanks() && (after_equals || text_[at_] == '=') && tokens_.back().text != "!")
      return true;
    at_ = before;
    return false;
  }

  Status read_token(LaunchToken* out) {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (blank(c)) {
        if (!goes_on()) return ok();
      } else if (c == '"' || c == '\'') {
        if (auto status = quoted(out); !status) return status;
      } else {
        out->assigns |= read_character(out) == '=';
      }
    }
    return ok();
  }

  // One character, or the one after a backslash.
  char read_character(LaunchToken* out) {
    if (text_[at_] == '\\' && at_ + 1 < text_.size()) ++at_;
    out->text += text_[at_];
    return text_[at_++];
  }

  Status quoted(LaunchToken* out) {
    const size_t begin = at_;
    const char quote = text_[at_++];
    while (at_ < text_.size() && text_[at_] != quote) read_character(out);
    if (at_ == text_.size())
      return launch_error(text_, begin, "a quote is not closed",
                          std::string(1, quote) + " after it");
    ++at_;
    return ok();
  }

  const std::string_view text_;
  size_t at_ = 0;
  std::vector<LaunchToken> tokens_;
};

}  // namespace

Error launch_error(std::string_view text, size_t at, const std::string& what, std::string needed) {
  return Error{.code = Code::OPTION_SYNTAX,
               .what = "the pipeline cannot be read: " + what,
               .needed = std::move(needed),
               .difference = place_in(text, at)};
}

Result<std::vector<LaunchToken>> launch_tokens(std::string_view text) {
  return Cutter(text).run();
}

}  // namespace weir::app
