// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/config/ini.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "core/text/text.hpp"
#include "core/text/text_file.hpp"

namespace weir::config {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxBytes = 1 << 20, kMaxInLine = 4096, kMaxEntries = 4096, kMaxFaults = 16;
constexpr size_t kMaxShown = 60;

// Length in bytes of the first character of `text`; 0 if it is not printable UTF-8.
size_t character_at(std::string_view text) {
  const auto byte = [&](size_t i) -> uint32_t { return static_cast<unsigned char>(text[i]); };
  const uint32_t first = byte(0);
  if (first < 0x80) return first >= ' ' && first != 0x7F;
  const size_t bytes = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || text.size() < bytes) return 0;
  uint32_t code = first & (0xFFu >> (bytes + 1));
  for (size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return 0;
    code = code << 6 | (byte(i) & 0x3F);
  }
  // 0x80 to 0x9F are control characters.
  constexpr uint32_t kMin[] = {0, 0, 0xA0, 0x800, 0x10000};
  return code >= kMin[bytes] && code <= 0x10FFFF && (code < 0xD800 || code > 0xDFFF) ? bytes : 0;
}

// The start of a file's text for terminals and JSON: UTF-8, with ? for each invalid byte.
std::string shown(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const size_t bytes = character_at(text);
    if (out.size() + std::max<size_t>(bytes, 1) > kMaxShown) return out + "...";
    out += bytes ? text.substr(0, bytes) : "?";
    text.remove_prefix(std::max<size_t>(bytes, 1));
  }
  return out;
}

class Parser {
 public:
  explicit Parser(const std::string& name) : name_(name) {}

  Ini parse(std::string_view text) {
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    while (!text.empty() && !full()) {
      ++line_;
      const size_t end = text.find('\n');
      take(text.substr(0, end));
      text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    }
    return std::move(out_);
  }
  void fault(std::string_view text, const std::string& what, const std::string& needed) {
    const std::string place = name_ + (line_ ? ":" + std::to_string(line_) : "");
    out_.faults.push_back({.code = Code::OPTION_SYNTAX,
                           .what = place + ": " + what,
                           .offered = shown(text),
                           .needed = needed});
  }

 private:
  bool full() {
    if (out_.faults.size() < kMaxFaults && out_.entries.size() < kMaxEntries) return false;
    fault("", "too many keys: the rest of the file is ignored", "at most 4096 keys");
    return true;
  }
  void take(std::string_view raw) {
    if (raw.size() > kMaxInLine) return fault(raw, "the line is too long", "at most 4096 bytes");
    if (raw.find('\0') != std::string_view::npos)
      return fault(raw, "the line is not text", "no byte 0");
    const auto text = strip(raw);
    if (text.empty() || text.front() == '#' || text.front() == ';') return;
    if (text.front() == '[') return open_group(text);
    const size_t equals = text.find('=');
    const auto key = strip(text.substr(0, equals));
    if (equals == std::string_view::npos || key.empty())
      return fault(text, "the line is neither a group nor a key with its value",
                   "[group], key=value, or # and a comment");
    if (group_.empty())
      return fault(text, "the key is not in a group", "a line [group] before it, such as [filter]");
    if (!skipping_)
      out_.entries.push_back(
          {group_, std::string(key), std::string(strip(text.substr(equals + 1))), line_});
  }
  // Keys of a group whose name is unreadable are dropped.
  void open_group(std::string_view text) {
    const auto name = text.size() > 2 ? strip(text.substr(1, text.size() - 2)) : "";
    skipping_ = text.back() != ']' || name.empty() || name.find_first_of("[]") != name.npos;
    group_ = skipping_ ? "?" : std::string(name);
    if (skipping_) fault(text, "the group name cannot be read", "[name]");
  }

  const std::string& name_;
  size_t line_ = 0;
  std::string group_;
  bool skipping_ = false;
  Ini out_;
};

}  // namespace

Ini parse_ini(std::string_view text, const std::string& name) {
  Parser parser(name);
  if (text.size() <= kMaxBytes) return parser.parse(text);
  parser.fault("", "the file is too long", "at most 1 MiB");
  return parser.parse("");
}

Ini read_ini(const std::string& path) {
  std::error_code ignored;
  std::ifstream file;
  if (fs::is_regular_file(path, ignored)) file.open(path, std::ios::binary);
  if (!file.is_open())
    return {{},
            {{.code = Code::FILE_NOT_FOUND,
              .what = "the configuration file cannot be read",
              .offered = path,
              .needed = "a file that can be read",
              .difference = why_unreadable(path)}}};
  std::string text(kMaxBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad())
    return {{},
            {{.code = Code::FILE_NOT_FOUND,
              .what = "the configuration file cannot be read",
              .offered = path,
              .needed = "a file that can be read",
              .difference = std::generic_category().message(errno)}}};
  text.resize(static_cast<size_t>(file.gcount()));
  return parse_ini(text, path);
}

bool truth(std::string_view text, bool otherwise) noexcept {
  const auto begins = [&](std::string_view letters) {
    return !text.empty() && letters.find(text.front()) != std::string_view::npos;
  };
  const auto second = [&](char c) { return text.size() > 1 && (text[1] | 0x20) == c; };
  if (begins("1tTyY") || (begins("oO") && second('n'))) return true;
  if (begins("0fFnN") || (begins("oO") && second('f'))) return false;
  return otherwise;
}

}  // namespace weir::config
