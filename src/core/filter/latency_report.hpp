// LatencyReport: the latency that a filter reports, and when the report is outdated
// (docs/compatibility/filter.md 4.7). Times are nanoseconds. Thread-safe.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <mutex>

namespace weir {

class LatencyReport {
 public:
  // The latency to report in a LATENCY query: the `average` of the invokes plus 5 %.
  uint64_t update(uint64_t average) noexcept;
  // After an invoke: whether the pipeline must query the latency again, because the average exceeds
  // the last report or is more than 25 % below it. Returns true once for each such change and
  // assumes that the pipeline then queries.
  bool outdated(uint64_t average) noexcept;
  void reset() noexcept;

 private:
  std::mutex mutex_;  // guards the members below
  uint64_t reported_ = 0;
};

}  // namespace weir
