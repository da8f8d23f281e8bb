// Latency: the time from the push of a frame to the arrival of the same timestamp at a sink.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <compare>
#include <cstdint>
#include <vector>

namespace weir::trace {

struct Bucket {
  int64_t from = 0, to = 0;  // ns; from <= latency < to
  uint64_t frames = 0;
};

struct Latency {
  uint64_t frames = 0;
  uint64_t unmatched = 0;  // no timestamp, or one that was not pushed
  // In ns, 0 if no frame matched; percentiles by nearest rank.
  int64_t least = 0, mean = 0, median = 0, percentile_95 = 0, percentile_99 = 0, most = 0;
  std::vector<Bucket> buckets;  // each sqrt(2) wide, from the first to the last non-empty one
};

struct Departure {
  int64_t time_stamp = 0, time = 0;
  auto operator<=>(const Departure&) const = default;
};
using Departures = std::vector<Departure>;
struct Arrival {
  int64_t time_stamp = 0, time = 0;
};

// Measures a frame from the last departure of its timestamp that is not after its arrival.
// `departures` are sorted.
Latency latency(const Departures& departures, const std::vector<Arrival>& arrivals);

}  // namespace weir::trace
