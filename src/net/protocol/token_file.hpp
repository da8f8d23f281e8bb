// Files of certificates and tokens. TokenFile: the tokens that clients may send, read again when
// the file changes.
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

// Returns the text of the file that a client's "option" or a server's "property" names: `setting`
// is one of the two. FILE_NOT_FOUND, also for an empty file.
Result<std::string> read_security_file(const std::string& path, std::string_view setting,
                                       const std::string& name);

// Whether a header of a call (gRPC: metadata) can have this value: printable ASCII. gRPC accepts
// other bytes from a peer, but ends the process that sends them.
bool is_header_value(std::string_view text);

// The tokens that a file's text has, one on each line that is not empty.
struct Tokens {
  std::vector<std::string> sendable;
  // OPTION_VALUE for a text without tokens, or for the last token that no client can send, because
  // of bytes that a header cannot have. The error shows no token.
  Status status;
};

// `setting` names the file's "option" or "property" in errors, `path` is its file.
Tokens parse_tokens(std::string_view text, const std::string& path, const char* setting);

// Thread-safe.
class TokenFile {
 public:
  // Reads one token on each line. FILE_NOT_FOUND; OPTION_VALUE for a file without a token, or with
  // one that no client can send.
  static Result<std::unique_ptr<TokenFile>> open(const std::string& path);
  // Whether `header`, "Bearer TOKEN", has one of the tokens. Takes the same time for all tokens of
  // a length. Reads a file that was changed or replaced first; while it cannot be read or has no
  // token that clients can send, the tokens before are valid.
  bool allows(std::string_view header);

 private:
  explicit TokenFile(std::string path) : path_(std::move(path)) {}
  // Keeps the tokens that clients can send, also when it returns an error for another one.
  Status read();

  const std::string path_;
  std::mutex mutex_;  // guards the rest
  std::vector<std::string> tokens_;
  struct stat read_state_ {};  // of the file when it was read
};

}  // namespace weir::net
