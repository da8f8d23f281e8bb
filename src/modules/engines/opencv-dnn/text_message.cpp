// SPDX-License-Identifier: LGPL-2.1-or-later
#include "opencv-dnn/text_message.hpp"

#include <algorithm>
#include <charconv>

namespace weir::engine {
namespace {

constexpr int kDepthLimit = 32;

class Parser {
 public:
  explicit Parser(std::string_view text) : text_(text) {}

  Status message(TextMessage* out, char end, int depth) {
    if (depth > kDepthLimit) return error("messages are nested too deeply");
    for (skip(); at_ < text_.size() && text_[at_] != end; skip())
      if (auto status = field(out, depth); !status) return status;
    if (end == '\0') return ok();
    if (at_ == text_.size()) return error("a message that is not closed");
    ++at_;
    return ok();
  }

 private:
  Status field(TextMessage* out, int depth) {
    TextMessage::Field field;
    field.name = word();
    if (field.name.empty()) return error("a field name is missing");
    skip();
    const bool colon = take(':');
    skip();
    if (auto status = content(std::move(field), colon, out, depth); !status) return status;
    skip();
    if (at_ < text_.size() && (text_[at_] == ';' || text_[at_] == ',')) ++at_;
    return ok();
  }

  // A message, a list or a value.
  Status content(TextMessage::Field field, bool colon, TextMessage* out, int depth) {
    if (take('{') || take('<')) {
      const char end = text_[at_ - 1] == '{' ? '}' : '>';
      field.message = std::make_unique<TextMessage>();
      if (auto status = message(field.message.get(), end, depth + 1); !status) return status;
    } else if (!colon) {
      return error("no value for " + field.name);
    } else if (take('[')) {
      return list(field.name, out);
    } else if (auto status = value(&field.value); !status) {
      return status;
    }
    out->fields.push_back(std::move(field));
    return ok();
  }

  Status list(const std::string& name, TextMessage* out) {
    for (skip(); !take(']'); skip()) {
      TextMessage::Field field;
      field.name = name;
      if (auto status = value(&field.value); !status) return status;
      out->fields.push_back(std::move(field));
      skip();
      take(',');
    }
    return ok();
  }

  Status value(std::string* out) {
    if (at_ < text_.size() && (text_[at_] == '"' || text_[at_] == '\'')) {
      const char quote = text_[at_++];
      for (; at_ < text_.size() && text_[at_] != quote && text_[at_] != '\n'; ++at_) {
        if (text_[at_] == '\\' && at_ + 1 < text_.size()) ++at_;
        *out += text_[at_];
      }
      return take(quote) ? ok() : error("a string that is not closed");
    }
    *out = word();
    return out->empty() ? error("no value") : ok();
  }

  std::string word() {
    const size_t begin = at_;
    while (at_ < text_.size() && is_word(text_[at_])) ++at_;
    return std::string(text_.substr(begin, at_ - begin));
  }
  static bool is_word(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '+' || c == '.';
  }
  bool take(char c) {
    if (at_ == text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  void skip() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '#')
        at_ = std::min(text_.find('\n', at_), text_.size());
      else if (c == ' ' || c == '\t' || c == '\r' || c == '\n')
        ++at_;
      else
        return;
    }
  }
  Error error(const std::string& what) const {
    const auto line =
        1 + std::count(text_.begin(), text_.begin() + static_cast<ptrdiff_t>(at_), '\n');
    return Error{.code = Code::MODEL_INVALID,
                 .what = "the description of the network cannot be read",
                 .offered = "line " + std::to_string(line) + ": " + what,
                 .needed = "protobuf's text format, as Caffe writes it"};
  }

  std::string_view text_;
  size_t at_ = 0;
};

std::optional<int64_t> number_in(std::string_view text) {
  int64_t out = 0;
  const auto [end, bad] = std::from_chars(text.data(), text.data() + text.size(), out);
  if (bad != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return out;
}

}  // namespace

std::string TextMessage::text(std::string_view name) const {
  for (const auto& field : fields)
    if (field.name == name && !field.message) return field.value;
  return {};
}

std::optional<int64_t> TextMessage::number(std::string_view name) const {
  const auto all = numbers(name);
  return all.empty() ? std::nullopt : std::optional(all.front());
}

std::vector<int64_t> TextMessage::numbers(std::string_view name) const {
  std::vector<int64_t> out;
  for (const auto& field : fields)
    if (const auto value = number_in(field.value); field.name == name && value)
      out.push_back(*value);
  return out;
}

std::vector<const TextMessage*> TextMessage::messages(std::string_view name) const {
  std::vector<const TextMessage*> out;
  for (const auto& field : fields)
    if (field.name == name && field.message) out.push_back(field.message.get());
  return out;
}

Result<TextMessage> read_text_message(std::string_view text) {
  TextMessage out;
  if (auto status = Parser(text).message(&out, '\0', 0); !status) return status.error();
  return out;
}

}  // namespace weir::engine
