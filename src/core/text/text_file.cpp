// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/text_file.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <system_error>

#include "core/text/shell_quote.hpp"
#include "weir/module.hpp"

namespace weir {
namespace {

constexpr size_t kMaxFileBytes = 16 << 20;  // bytes

}  // namespace

std::string read_text_file(const std::string& option, const std::string& path) {
  const auto failure = [&](const std::string& reason) {
    return Failure({.code = Code::FILE_NOT_FOUND,
                    .what = "the file of " + option + " cannot be read: " + reason,
                    .offered = path.empty() ? "an empty path" : path,
                    .needed = "a readable text file of at most 16 MiB",
                    .fix = "ls -l " + shell_word(path)});
  };
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"),
                                                             std::fclose);
  if (!file) throw failure(std::strerror(errno));
  std::string text;
  char block[4096];
  while (const size_t read = std::fread(block, 1, sizeof block, file.get())) {
    text.append(block, read);
    if (text.size() > kMaxFileBytes) throw failure("it is too long");
  }
  if (std::ferror(file.get())) throw failure(std::strerror(errno));
  return text;
}

std::string why_unreadable(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code failed;
  switch (fs::status(path, failed).type()) {
    case fs::file_type::not_found:
      return "it does not exist";
    case fs::file_type::directory:
      return "it is a folder";
    case fs::file_type::regular:
      errno = 0;
      return std::ifstream(path) ? "" : std::generic_category().message(errno);
    default:
      return failed ? failed.message() : "it is not a regular file";
  }
}

}  // namespace weir
