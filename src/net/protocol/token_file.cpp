// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/protocol/token_file.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <iterator>

namespace weir::net {
namespace {

// Compares without an end at the first difference, which would show how much of a guess is right.
bool same_text(std::string_view one, std::string_view other) {
  if (one.size() != other.size()) return false;
  volatile unsigned char difference = 0;
  for (size_t i = 0; i < one.size(); ++i)
    difference = difference | static_cast<unsigned char>(one[i] ^ other[i]);
  return difference == 0;
}

bool same_file(const struct stat& one, const struct stat& other) {
  return one.st_dev == other.st_dev && one.st_ino == other.st_ino && one.st_size == other.st_size &&
         one.st_mtim.tv_sec == other.st_mtim.tv_sec && one.st_mtim.tv_nsec == other.st_mtim.tv_nsec;
}

std::vector<std::string_view> split_lines(std::string_view text) {
  std::vector<std::string_view> out;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    out.push_back(text.substr(begin, end - begin));
    if (out.back().ends_with('\r')) out.back().remove_suffix(1);
    begin = end + 1;
  }
  return out;
}

Error no_token(const std::string& path, const char* setting) {
  return {.code = Code::OPTION_VALUE,
          .what = std::string("the file of the ") + setting + " token-file has no token",
          .offered = path,
          .needed = "one token on each line",
          .fix = "openssl rand -hex 32 > " + path};
}

std::string describe_byte(std::string_view token, size_t at) {
  if (at == 0 && token.starts_with("\xEF\xBB\xBF")) return "a UTF-8 byte order mark";
  std::array<char, 8> hex{};
  std::snprintf(hex.data(), hex.size(), "0x%02X", static_cast<unsigned char>(token[at]));
  return "the byte " + std::string(hex.data());
}

Status check_token(std::string_view token, const std::string& path, size_t line,
                   const char* setting) {
  size_t at = 0;
  while (at < token.size() && is_header_value(token.substr(at, 1))) ++at;
  if (at == token.size()) return ok();
  return Error{.code = Code::OPTION_VALUE,
               .what = std::string("the file of the ") + setting +
                       " token-file has a token that cannot be sent",
               .offered = describe_byte(token, at) + " in column " + std::to_string(at + 1) +
                          " of line " + std::to_string(line) + " of " + path,
               .needed = "letters, digits, signs and spaces of ASCII",
               .fix = "LC_ALL=C sed -i 's/[^ -~]//g' " + path};
}

}  // namespace

Result<std::string> read_security_file(const std::string& path, std::string_view setting,
                                       const std::string& name) {
  std::ifstream in(path, std::ios::binary);
  std::string out{std::istreambuf_iterator<char>(in), {}};
  if (in && !out.empty()) return out;
  return Error{
      .code = Code::FILE_NOT_FOUND,
      .what = "the file of the " + std::string(setting) + " " + name + " cannot be read",
      .offered = path,
      .needed = "a file with text",
      .fix = setting == "option" ? "custom=" + name + ":/path/to/file" : name + "=/path/to/file"};
}

bool is_header_value(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

Tokens parse_tokens(std::string_view text, const std::string& path, const char* setting) {
  Tokens out{.sendable = {}, .status = ok()};
  const auto lines = split_lines(text);
  for (size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].empty()) continue;
    if (auto status = check_token(lines[i], path, i + 1, setting); !status)
      out.status = status;
    else
      out.sendable.emplace_back(lines[i]);
  }
  if (out.sendable.empty() && out.status) out.status = no_token(path, setting);
  return out;
}

Result<std::unique_ptr<TokenFile>> TokenFile::open(const std::string& path) {
  std::unique_ptr<TokenFile> out(new TokenFile(path));
  if (auto status = out->read(); !status) return status.error();
  return out;
}

Status TokenFile::read() {
  // Before the text: a change while it is read is noticed the next time.
  struct stat state {};
  if (stat(path_.c_str(), &state) == 0) read_state_ = state;
  auto text = read_security_file(path_, "property", "token-file");
  if (!text) return text.error();
  auto tokens = parse_tokens(*text, path_, "property");
  if (!tokens.sendable.empty()) tokens_ = std::move(tokens.sendable);
  return tokens.status;
}

bool TokenFile::allows(std::string_view header) {
  constexpr std::string_view kScheme = "Bearer ";
  if (header.substr(0, kScheme.size()) != kScheme) return false;
  std::lock_guard lock(mutex_);
  struct stat state {};
  if (stat(path_.c_str(), &state) == 0 && !same_file(state, read_state_)) (void)read();
  bool known = false;
  for (const auto& token : tokens_)
    known = same_text(header.substr(kScheme.size()), token) || known;
  return known;
}

}  // namespace weir::net
