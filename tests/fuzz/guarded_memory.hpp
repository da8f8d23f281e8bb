// GuardedMemory: bytes that end directly before an inaccessible mebibyte. Code without sanitizer
// instrumentation, such as LuaJIT's, gets a signal there.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <sys/mman.h>

#include <utility>

#include "fuzz_input.hpp"

namespace weir::fuzz {

class GuardedMemory {
 public:
  explicit GuardedMemory(size_t bytes)
      : size_(bytes), mapped_((bytes / kPage + 1) * kPage + kGuard) {
    void* const at =
        mmap(nullptr, mapped_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    require(at != MAP_FAILED, "memory can be mapped");
    begin_ = static_cast<std::byte*>(at);
    require(mprotect(begin_ + mapped_ - kGuard, kGuard, PROT_NONE) == 0, "memory can be guarded");
  }
  GuardedMemory(GuardedMemory&& other) noexcept
      : begin_(std::exchange(other.begin_, nullptr)), size_(other.size_), mapped_(other.mapped_) {}
  GuardedMemory& operator=(GuardedMemory&&) = delete;
  ~GuardedMemory() {
    if (begin_) munmap(begin_, mapped_);
  }

  std::byte* data() const noexcept { return begin_ + mapped_ - kGuard - size_; }
  size_t size() const noexcept { return size_; }

 private:
  static constexpr size_t kPage = 4096, kGuard = 1 << 20;
  std::byte* begin_;
  size_t size_, mapped_;
};

}  // namespace weir::fuzz
