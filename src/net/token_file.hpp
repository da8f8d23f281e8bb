// TokenFile: the tokens that clients may send, read again when the file changes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <sys/stat.h>

#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "weir/result.hpp"

namespace weir::net {

// Thread-safe.
class TokenFile {
 public:
  // One token on each line. FILE_NOT_FOUND; OPTION_VALUE for a file without a token.
  static Result<std::unique_ptr<TokenFile>> open(const std::string& path);
  // Whether `header`, "Bearer TOKEN", has one of the tokens. Takes the same time for all tokens of
  // a length. Reads a file that was changed or replaced first; while it cannot be read or has no
  // token, the tokens before are valid.
  bool allows(std::string_view header);

 private:
  explicit TokenFile(std::string path) : path_(std::move(path)) {}
  Status read();

  const std::string path_;
  std::mutex mutex_;  // guards the rest
  std::vector<std::string> tokens_;
  struct stat read_state_ {};  // of the file when it was read
};

}  // namespace weir::net
