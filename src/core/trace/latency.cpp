// Matches frames by their timestamps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/latency.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/trace/record.hpp"

namespace weir::trace {
namespace {

constexpr double kFirstBound = 1000;  // ns

int64_t bound(size_t bucket) {  // the lower bound
  return bucket == 0
             ? 0
             : std::llround(kFirstBound * std::pow(2.0, (static_cast<double>(bucket) - 1) / 2));
}

size_t bucket_of(int64_t value) {
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
  const size_t first = bucket_of(sorted.front());
  for (const int64_t value : sorted) {
    while (out.empty() || value >= out.back().to) {
      const size_t next = first + out.size();
      out.push_back({bound(next), bound(next + 1), 0});
    }
    ++out.back().frames;
  }
  return out;
}

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
  out.least = values.front();
  out.most = values.back();
  out.mean = std::accumulate(values.begin(), values.end(), int64_t{0}) /
             static_cast<int64_t>(values.size());
  out.median = nearest_rank(values, 50);
  out.percentile_95 = nearest_rank(values, 95);
  out.percentile_99 = nearest_rank(values, 99);
  out.buckets = histogram(values);
  return out;
}

}  // namespace weir::trace
