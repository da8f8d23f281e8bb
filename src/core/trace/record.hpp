// Record: one event that a tracer records. Fixed size, without text or ownership.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>

namespace weir::trace {

inline constexpr int64_t kNoTime = -1;

// Spans begin and end on one thread and nest there.
enum class Kind : uint8_t {
  PushBegin,
  PushEnd,
  PullBegin,
  PullEnd,
  EventBegin,
  EventEnd,
  StateBegin,
  StateEnd,
  Level,
  ThreadTime  // comes directly before a PushBegin or PushEnd
};

inline constexpr uint64_t kMaxFrames = (uint64_t{1} << 20) - 1;
inline constexpr uint64_t kMaxBytes = (uint64_t{1} << 40) - 1;

struct Record {
  int64_t time = 0;  // nanoseconds of one monotonic clock
  const void* object =
      nullptr;  // the pad that pushes or pulls; State: the element; Level: the queue
  union {
    int64_t value = 0;  // PushBegin: timestamp in ns or kNoTime; ends: 0 = success; Level: buffers;
                        // ThreadTime: CPU time of the thread in ns
    const char* name;   // EventBegin, StateBegin: a string with static storage
  };
  uint64_t kind : 4 = 0;     // a Kind
  uint64_t frames : 20 = 0;  // pushes and pulls; Level: fill level in thousandths
  uint64_t bytes : 40 = 0;   // pushes and pulls, Level
};
static_assert(sizeof(Record) == 32);

}  // namespace weir::trace
