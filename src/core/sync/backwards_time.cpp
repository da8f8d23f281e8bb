// Words for times that go backwards.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/sync/backwards_time.hpp"

#include "core/text/text.hpp"

namespace weir {

Error backwards_time(uint64_t time, uint64_t before, OnBackwardsTime what) {
  const bool dropped = what == OnBackwardsTime::Drop;
  return {Code::TIME_INVALID,
          std::string("a time-stamp goes backwards: such frames are ") +
              (dropped ? "dropped and counted" : "counted and passed on"),
          time_text(time),
          "at least " + time_text(before) + ", the time before",
          "",
          dropped
              ? "on-backwards-time=pass keeps them; identity single-segment=true in front mends "
                "streams that were joined"
              : "on-backwards-time=drop leaves them out"};
}

}  // namespace weir
