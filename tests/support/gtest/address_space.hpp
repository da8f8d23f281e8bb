// What limits the address space of a test process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <sys/resource.h>

#include <algorithm>

namespace weir {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kIsSanitized = true;
#elif defined(__has_feature)
inline constexpr bool kIsSanitized =
    __has_feature(address_sanitizer) || __has_feature(thread_sanitizer);
#else
inline constexpr bool kIsSanitized = false;
#endif

// Whether a limit of the address space holds. Sanitizers reserve terabytes of it, and the emulation
// of another processor (qemu-user) ignores the limit.
inline bool can_limit_address_space() {
  rlimit before{}, changed{};
  getrlimit(RLIMIT_AS, &before);
  const rlimit wanted{std::min(before.rlim_max, rlim_t{1} << 46), before.rlim_max};
  setrlimit(RLIMIT_AS, &wanted);
  getrlimit(RLIMIT_AS, &changed);
  setrlimit(RLIMIT_AS, &before);
  return !kIsSanitized && changed.rlim_cur == wanted.rlim_cur;
}

}  // namespace weir
