// IniFiles: files of groups and keys, read once for as long as they stay what they are.
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

// Any thread.
class IniFiles {
 public:
  // As read_ini; what was read before where the file has the device, inode, size and times that it
  // had then. A file that changed a moment ago may do so again within one tick of its clock: it is
  // read anew.
  std::shared_ptr<const Ini> read(const std::string& path);
  uint64_t reads() const;  // so far, of files

 private:
  struct Kept {
    struct stat identity {};
    std::shared_ptr<const Ini> ini;
  };
  mutable std::mutex mutex_;  // guards the rest
  std::map<std::string, Kept> kept_;
  uint64_t reads_ = 0;
};

}  // namespace weir::config
