// The reason why a file cannot be read.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/unreadable.hpp"

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace weir {

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
