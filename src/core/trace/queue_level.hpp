// QueueLevel: how many frames stood in a queue, from what went in, what left, and samples of it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace weir::trace {

struct QueueChange {
  int64_t time = 0;
  int64_t frames = 0;  // came (more than 0) or left; with `sampled`: stand in it
  bool sampled = false;
};

struct QueueLevel {
  struct Step {
    int64_t time = 0;
    uint64_t frames = 0;  // from then on
  };
  std::vector<Step> steps;  // in time
  uint64_t most = 0;
  double mean = 0;  // over time, from the first change to `end`
};

// Counted between samples, which set it right: queues that leak drop what was counted.
QueueLevel queue_level(std::vector<QueueChange> changes, int64_t end);

// The highest level in each of `count` equal parts of [begin, end].
std::vector<uint64_t> highest_levels(const QueueLevel& level, int64_t begin, int64_t end,
                                     size_t count);

}  // namespace weir::trace
