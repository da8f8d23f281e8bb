// Files that appear whole or not at all, and never replace others.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

#include "weir/result.hpp"

namespace weir::app {

struct NewFile {
  std::filesystem::path path;
  std::string text;
  mode_t mode;  // exactly, whatever the umask is
};

// Writes all of the files or none. An existing file is an error. After a power cut each file is
// whole or absent.
Status write_new_files(const std::vector<NewFile>& files);

}  // namespace weir::app
