// The addresses in the properties of an element of weiredge.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <utility>

#include "transport/host_text.hpp"

namespace weir {

// Returns the settings with host and dest-host as they are meant (transport/host_text.hpp). The
// properties read as they were set.
template <class Settings>
Settings read_addresses(Settings s) {
  static const Settings kDefaults;
  transport::read_address(&s.dest_host, &s.dest_port, kDefaults.dest_port);
  if constexpr (requires { transport::read_address(&s.host, &s.port, kDefaults.port); })
    transport::read_address(&s.host, &s.port, kDefaults.port);
  return s;
}

}  // namespace weir
