// What a listener does when a peer waits and no descriptor or memory is free: it pauses, because
// its socket stays readable all the time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cerrno>
#include <chrono>

namespace weir::transport {

// Until the next attempt to accept a peer.
inline constexpr std::chrono::milliseconds kAcceptPause{100};

// Whether accept() failed with this errno for a reason that may pass.
inline bool is_out_of_resources(int error) noexcept {
  return error == EMFILE || error == ENFILE || error == ENOBUFS || error == ENOMEM;
}

inline constexpr char kOutOfResourcesFix[] =
    "ulimit -n $(ulimit -Hn), in the shell that starts the program, or fewer programs on this "
    "machine";

}  // namespace weir::transport
