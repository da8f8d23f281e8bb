// LatencyReport: what a filter says of its latency, and when what it said is no longer true
// (specification 4.7). Times are nanoseconds. Thread-safe.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <mutex>

namespace weir {

class LatencyReport {
 public:
  // For a query: `average` of the invokes with a margin of 5 %.
  uint64_t answer(uint64_t average) noexcept;
  // After an invoke: whether the pipeline must ask anew, because the average is above what was
  // answered or more than 25 % beside it. True once for each such change: the pipeline is taken to
  // have asked.
  bool outdated(uint64_t average) noexcept;
  void reset() noexcept;

 private:
  std::mutex mutex_;  // guards the rest
  uint64_t reported_ = 0;
};

}  // namespace weir
