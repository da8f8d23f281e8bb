// QueueLevel: the number of frames in a queue over time, from its input, its output and samples.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace weir::trace {

struct QueueChange {
  int64_t time = 0;
  int64_t frames = 0;  // arrived (above 0) or left; with `sampled`: the current level
  bool sampled = false;
};

struct QueueLevel {
  struct Step {
    int64_t time = 0;
    uint64_t frames = 0;  // from this time on
  };
  std::vector<Step> steps;  // in order of time
  uint64_t max = 0;
  double mean = 0;  // weighted by time, from the first change to `end`
};

// Counts between samples; samples correct the count, because leaky queues drop counted frames.
QueueLevel queue_level(std::vector<QueueChange> changes, int64_t end);

// The highest level in each of `count` equal parts of [begin, end].
std::vector<uint64_t> highest_levels(const QueueLevel& level, int64_t begin, int64_t end,
                                     size_t count);

}  // namespace weir::trace
