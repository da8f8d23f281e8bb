// Numbers by which a server or publisher knows its peers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <random>

namespace weir::edge {

// Random, so that it cannot be guessed, and positive: 62 bits.
inline int64_t new_client_id() {
  std::random_device device;
  return static_cast<int64_t>((uint64_t{device()} << 32 | device()) >> 2);
}

}  // namespace weir::edge
