// Interruption: ends waits of another thread that poll its descriptor.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <sys/eventfd.h>
#include <unistd.h>

#include <cstdint>

#include "core/isolate/descriptor.hpp"

namespace weir::local {

// Any thread.
class Interruption {
 public:
  Interruption() : event_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}
  int descriptor() const noexcept { return event_.get(); }  // readable while set
  void set() noexcept {
    const uint64_t one = 1;
    [[maybe_unused]] const ssize_t written = write(event_.get(), &one, sizeof one);
  }
  void clear() noexcept {
    uint64_t count = 0;
    [[maybe_unused]] const ssize_t got = read(event_.get(), &count, sizeof count);
  }

 private:
  isolate::Descriptor event_;
};

}  // namespace weir::local
