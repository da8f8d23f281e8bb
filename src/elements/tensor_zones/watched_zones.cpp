// Compares the state of the zones file before each frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_zones/watched_zones.hpp"

namespace weir {

Status WatchedZones::open(const std::string& path) {
  zones_.reset();
  if (path.empty())
    return Error{.code = Code::OPTION_VALUE,
                 .what = "tensor_zones has no zones",
                 .offered = "zones=\"\"",
                 .needed = "a JSON file as docs/zones.md defines it",
                 .fix = "tensor_zones zones=/path/to/zones.json"};
  const auto read = follow(path);
  return read ? ok() : Status(read.error());
}

Result<bool> WatchedZones::follow(const std::string& path) {
  // The state before reading: what is written meanwhile is read before the next frame.
  const zone::FileState state = zone::state_of_file(path);
  if (zones_ && path == path_ && state == state_) return false;
  path_ = path;
  state_ = state;
  auto read = zone::read_zones(path);
  if (!read) return read.error();
  zones_ = std::make_shared<const zone::ZoneSet>(*std::move(read));
  return true;
}

}  // namespace weir
