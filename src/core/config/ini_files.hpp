// IniFiles: a cache of ini files that rereads a file only after it has changed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <sys/stat.h>

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "core/config/ini.hpp"

namespace weir::config {

// Thread-safe.
class IniFiles {
 public:
  // As read_ini(). Returns the cached result if the file's device, inode, size and times are
  // unchanged. A file that changed a moment ago is read again, because a second change within one
  // clock tick would not be visible.
  std::shared_ptr<const Ini> read(const std::string& path);
  uint64_t reads() const;  // files read so far

 private:
  struct Kept {
    struct stat identity {};
    std::shared_ptr<const Ini> ini;
  };
  mutable std::mutex mutex_;  // guards the members below
  std::map<std::string, Kept> kept_;
  uint64_t reads_ = 0;
};

}  // namespace weir::config
