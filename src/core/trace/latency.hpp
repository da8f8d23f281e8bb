// Latency: from when a source pushed a frame to when one of the same time-stamp came to a sink.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <map>
#include <vector>

namespace weir::trace {

struct Bucket {
  int64_t from = 0, to = 0;  // ns; from <= latency < to
  uint64_t frames = 0;
};

struct Latency {
  uint64_t frames = 0;
  uint64_t unmatched = 0;  // no time-stamp, or none of the source's
  // ns, 0 where no frame was matched; percentiles by nearest rank
  int64_t least = 0, mean = 0, median = 0, percentile_95 = 0, percentile_99 = 0, most = 0;
  std::vector<Bucket> buckets;  // each sqrt(2) wide, from the first to the last that is not empty
};

// Time-stamp to the times it was pushed at.
using Departures = std::multimap<int64_t, int64_t>;
struct Arrival {
  int64_t time_stamp = 0, time = 0;
};

// A frame counts from the last departure of its time-stamp that is not after its arrival.
Latency latency(const Departures& departures, const std::vector<Arrival>& arrivals);

}  // namespace weir::trace
