// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/latency.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "core/trace/record.hpp"

namespace weir::trace {
namespace {

constexpr double kFirstBound = 1000;  // ns

int64_t bound(size_t bucket) {  // the lower bound
  return bucket == 0
             ? 0
             : std::llround(kFirstBound * std::pow(2.0, (static_cast<double>(bucket) - 1) / 2));
}

size_t find_bucket(int64_t value) {
  size_t bucket = 0;
  while (bound(bucket + 1) <= value) ++bucket;
  return bucket;
}

int64_t nearest_rank(const std::vector<int64_t>& sorted, unsigned percent) {
  const size_t rank = (sorted.size() * percent + 99) / 100;
  return sorted[std::max<size_t>(rank, 1) - 1];
}

int64_t departure_before(const Departures& departures, const Arrival& arrival) {
  if (arrival.time_stamp == kNoTime) return kNoTime;
  const auto after = std::upper_bound(departures.begin(), departures.end(),
                                      Departure{arrival.time_stamp, arrival.time});
  if (after == departures.begin()) return kNoTime;
  const Departure& last = *std::prev(after);
  return last.time_stamp == arrival.time_stamp ? last.time : kNoTime;
}

std::vector<Bucket> histogram(const std::vector<int64_t>& sorted) {
  std::vector<Bucket> out;
  const size_t first = find_bucket(sorted.front());
  for (const int64_t value : sorted) {
    while (out.empty() || value >= out.back().to) {
      const size_t next = first + out.size();
      out.push_back({bound(next), bound(next + 1), 0});
    }
    ++out.back().frames;
  }
  return out;
}

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

Latency latency(const Departures& departures, const std::vector<Arrival>& arrivals) {
  Latency out;
  std::vector<int64_t> values;
  for (const Arrival& arrival : arrivals) {
    const int64_t left = departure_before(departures, arrival);
    if (left == kNoTime)
      ++out.unmatched;
    else
      values.push_back(arrival.time - left);
  }
  out.frames = values.size();
  if (values.empty()) return out;
  std::sort(values.begin(), values.end());
  out.min = values.front();
  out.max = values.back();
  out.mean = std::accumulate(values.begin(), values.end(), int64_t{0}) /
             static_cast<int64_t>(values.size());
  out.median = nearest_rank(values, 50);
  out.percentile_95 = nearest_rank(values, 95);
  out.percentile_99 = nearest_rank(values, 99);
  out.buckets = histogram(values);
  return out;
}

std::vector<StreamLatency> stream_latencies(const Graph& graph,
                                            const std::vector<std::pair<size_t, size_t>>& links,
                                            StreamRecords records) {
  return Streams(graph, links, std::move(records)).measure();
}

}  // namespace weir::trace
