// Reads and compares tokens.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/token_file.hpp"

#include <fstream>

#include "net/server_security.hpp"

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

}  // namespace

Result<std::unique_ptr<TokenFile>> TokenFile::open(const std::string& path) {
  std::unique_ptr<TokenFile> out(new TokenFile(path));
  if (auto status = out->read(); !status) return status.error();
  return out;
}

Status TokenFile::read() {
  // Before the text: a change while it is read is noticed the next time.
  struct stat state {};
  if (stat(path_.c_str(), &state) == 0) read_state_ = state;
  auto text = read_security_file(path_, "token-file");
  if (!text) return text.error();
  std::vector<std::string> tokens;
  for (size_t begin = 0; begin < text->size();) {
    const size_t end = std::min(text->find('\n', begin), text->size());
    std::string line = text->substr(begin, end - begin);
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (!line.empty()) tokens.push_back(std::move(line));
    begin = end + 1;
  }
  if (tokens.empty())
    return Error{.code = Code::OPTION_VALUE,
                 .what = "the file of the property token-file has no token",
                 .offered = path_,
                 .needed = "one token on each line",
                 .fix = "openssl rand -hex 32 > " + path_};
  tokens_ = std::move(tokens);
  return ok();
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
