// Keeps an address of the plug-in weirnet open while no pipeline serves there, for programs that
// restart pipelines.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>
#include <memory>
#include <string>

#include "core/process/process_object.hpp"

namespace weir::process {

// "127.0.0.1:8001" or "unix:PATH", where this process listens: clients are answered there until the
// result goes. Null when nothing listens there.
using LeaseListener = std::shared_ptr<const void> (*)(const std::string& address);

// Null until weirnet is loaded.
inline std::atomic<LeaseListener>& lease_listener() {
  return object<std::atomic<LeaseListener>>("lease-listener");
}

}  // namespace weir::process
