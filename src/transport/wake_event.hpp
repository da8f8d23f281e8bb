// WakeEvent: ends a poll() of another thread.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <sys/eventfd.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <system_error>

#include "machine/descriptor.hpp"

namespace weir::transport {

// Thread-safe.
class WakeEvent {
 public:
  // Throws std::system_error without a free descriptor: nothing could end a poll() then.
  WakeEvent() {
    if (!event_)
      throw std::system_error(errno, std::generic_category(),
                              "no file descriptor to wake a thread with (ulimit -n)");
  }
  // Readable while set.
  int descriptor() const noexcept { return event_.get(); }
  void set() noexcept {
    const uint64_t one = 1;
    [[maybe_unused]] const ssize_t written = write(event_.get(), &one, sizeof one);
  }
  void clear() noexcept {
    uint64_t count = 0;
    [[maybe_unused]] const ssize_t got = read(event_.get(), &count, sizeof count);
  }
  // Whether set_if_wanted() sets it; once.
  void set_wanted(bool wanted) noexcept { wanted_ = wanted; }
  void set_if_wanted() noexcept {
    if (wanted_.exchange(false)) set();
  }

 private:
  const io::Descriptor event_{eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
  std::atomic<bool> wanted_{false};
};

}  // namespace weir::transport
