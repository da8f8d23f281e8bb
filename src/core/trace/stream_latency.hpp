// Latencies of a whole graph: for each source and each sink that it reaches, from the pad at which
// the timestamps begin that arrive at the sink.
//
// A file source pushes bytes without timestamps; they begin at the source pad of the demuxer, or
// behind a parser that makes up for those that a container lacks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <vector>

#include "core/trace/graph.hpp"
#include "core/trace/latency.hpp"

namespace weir::trace {

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
