// WatchedZones: the zones of a file that may be replaced while a stream plays.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <optional>
#include <string>

#include "core/zone/zone_file.hpp"

namespace weir {

// One thread.
class WatchedZones {
 public:
  // Reads the file. Errors: read_zones(), and OPTION_VALUE without a path.
  Status open(const std::string& path);
  // Call before a frame: reads the file again if `path` is another one or its file has changed.
  // True when the zones were replaced. An error is returned once for each change, and the zones
  // stay.
  Result<bool> follow(const std::string& path);
  const std::shared_ptr<const zone::ZoneSet>& zones() const noexcept { return zones_; }

 private:
  std::string path_;
  zone::FileState state_;
  std::shared_ptr<const zone::ZoneSet> zones_;
};

}  // namespace weir
