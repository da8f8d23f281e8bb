// Pins the process to one core, so that effects of other threads on shared cores do not distort a
// comparison with a single-threaded loop.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <sched.h>

namespace weir::bench {

// Pins this process and its threads to the first core that it may use.
inline void stay_on_one_core() {
  cpu_set_t allowed, one;
  CPU_ZERO(&allowed);
  CPU_ZERO(&one);
  if (sched_getaffinity(0, sizeof allowed, &allowed) != 0) return;
  for (int i = 0; i < CPU_SETSIZE; ++i)
    if (CPU_ISSET(i, &allowed)) {
      CPU_SET(i, &one);
      break;
    }
  sched_setaffinity(0, sizeof one, &one);
}

}  // namespace weir::bench
