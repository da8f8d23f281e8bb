// Latency: the time from the push of a frame to the arrival of the same timestamp at a sink.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <compare>
#include <cstdint>
#include <map>
#include <vector>

#include "core/trace/graph.hpp"

namespace weir::trace {

struct Bucket {
  int64_t from = 0, to = 0;  // ns; from <= latency < to
  uint64_t frames = 0;
};

struct Latency {
  uint64_t frames = 0;
  uint64_t unmatched = 0;  // no timestamp, or one that was not pushed
  // In ns, 0 if no frame matched; percentiles by nearest rank.
  int64_t min = 0, mean = 0, median = 0, percentile_95 = 0, percentile_99 = 0, max = 0;
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

struct StreamLatency {
  size_t source = kNone, sink = kNone;  // elements
  size_t origin = kNone;                // the source pad whose pushes latency counts from
  Latency latency;
};

struct StreamRecords {
  std::map<size_t, Departures> departures;          // by source pad, in any order
  std::map<size_t, std::vector<Arrival>> arrivals;  // by sink element
};

// Sources are elements without sink pads, sinks those without source pads. `links`: pairs of
// source and sink pad. The origin is the first pad on the way from the source of which most frames
// that arrive at the sink have a timestamp; else the one of the most.
std::vector<StreamLatency> stream_latencies(const Graph& graph,
                                            const std::vector<std::pair<size_t, size_t>>& links,
                                            StreamRecords records);

}  // namespace weir::trace
