// Walks the links from each source, nearest first.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/stream_latency.hpp"

#include <algorithm>
#include <set>

namespace weir::trace {
namespace {

class Streams {
 public:
  Streams(const Graph& graph, const std::vector<std::pair<size_t, size_t>>& links,
          StreamRecords records)
      : graph_(graph), records_(std::move(records)) {
    for (const auto& link : links) out_links_[graph.owner(link.first)].push_back(link);
    for (auto& [pad, departures] : records_.departures)
      std::sort(departures.begin(), departures.end());
  }

  std::vector<StreamLatency> measure() {
    std::vector<StreamLatency> out;
    for (size_t source = 0; source < graph_.elements().size(); ++source) {
      if (graph_.elements()[source].is_bin || graph_.has_pads(source, false)) continue;
      const auto downstream = links_from(source);
      for (const size_t sink : reached(source))
        if (!graph_.has_pads(sink, true)) out.push_back(from_origin(source, sink, downstream));
    }
    return out;
  }

 private:
  // Nearest first.
  std::vector<std::pair<size_t, size_t>> links_from(size_t source) {
    std::vector<std::pair<size_t, size_t>> out;
    std::vector<size_t> open{source};
    std::set<size_t> seen{source};
    for (size_t i = 0; i < open.size(); ++i)
      for (const auto& link : out_links_[open[i]]) {
        out.push_back(link);
        const size_t next = graph_.owner(link.second);
        if (seen.insert(next).second) open.push_back(next);
      }
    return out;
  }

  const std::set<size_t>& reached(size_t element) {
    const auto [found, is_new] = reached_.try_emplace(element);
    if (is_new)
      for (const auto& link : links_from(element)) found->second.insert(graph_.owner(link.second));
    return found->second;
  }

  StreamLatency from_origin(size_t source, size_t sink,
                            const std::vector<std::pair<size_t, size_t>>& downstream) {
    StreamLatency best{source, sink, kNone, {}};
    const auto& arrivals = records_.arrivals[sink];
    for (const auto& [pad, peer] : downstream) {
      const size_t next = graph_.owner(peer);
      if (next != sink && !reached(next).contains(sink)) continue;
      Latency latency = trace::latency(records_.departures[pad], arrivals);
      if (best.origin != kNone && latency.frames <= best.latency.frames) continue;
      best.origin = pad;
      best.latency = std::move(latency);
      if (best.latency.frames * 2 > arrivals.size()) break;
    }
    return best;
  }

  const Graph& graph_;
  StreamRecords records_;
  std::map<size_t, std::vector<std::pair<size_t, size_t>>> out_links_;  // by element
  std::map<size_t, std::set<size_t>> reached_;                          // by element
};

}  // namespace

std::vector<StreamLatency> stream_latencies(const Graph& graph,
                                            const std::vector<std::pair<size_t, size_t>>& links,
                                            StreamRecords records) {
  return Streams(graph, links, std::move(records)).measure();
}

}  // namespace weir::trace
