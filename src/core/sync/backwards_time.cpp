// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/sync/backwards_time.hpp"

#include "core/text/text.hpp"

namespace weir {

Error backwards_time(uint64_t time, uint64_t before, OnBackwardsTime what) {
  const bool dropped = what == OnBackwardsTime::Drop;
  return {.code = Code::TIME_INVALID,
          .what = std::string("a timestamp goes backwards; these frames are ") +
                  (dropped ? "dropped and counted" : "counted and passed on"),
          .offered = time_text(time),
          .needed = "at least " + time_text(before) + ", the previous timestamp",
          .fix = dropped ? "on-backwards-time=pass, to keep these frames; or identity "
                           "single-segment=true upstream, if streams were joined"
                         : "on-backwards-time=drop, to drop these frames"};
}

}  // namespace weir
