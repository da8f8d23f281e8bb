// Latency: the time from a source's push of a frame to the arrival of the same timestamp at a sink.
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
  uint64_t unmatched = 0;  // no timestamp, or not one of the source's
  // In ns, 0 if no frame matched; percentiles by nearest rank.
  int64_t least = 0, mean = 0, median = 0, percentile_95 = 0, percentile_99 = 0, most = 0;
  std::vector<Bucket> buckets;  // each sqrt(2) wide, from the first to the last non-empty one
};

// Maps each timestamp to the times at which it was pushed.
using Departures = std::multimap<int64_t, int64_t>;
struct Arrival {
  int64_t time_stamp = 0, time = 0;
};

// Measures a frame from the last departure of its timestamp that is not after its arrival.
Latency latency(const Departures& departures, const std::vector<Arrival>& arrivals);

}  // namespace weir::trace
