// Words for times that go backwards.
#include "core/sync/backwards_time.hpp"

#include <cinttypes>
#include <cstdio>

namespace weir {

std::string time_text(uint64_t nanoseconds) {
  constexpr uint64_t kSecond = 1'000'000'000;
  const uint64_t seconds = nanoseconds / kSecond;
  char text[48];
  std::snprintf(text, sizeof text, "%" PRIu64 ":%02" PRIu64 ":%02" PRIu64 ".%09" PRIu64,
                seconds / 3600, seconds / 60 % 60, seconds % 60, nanoseconds % kSecond);
  return text;
}

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
