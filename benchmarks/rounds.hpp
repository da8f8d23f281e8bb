// Interleaved rounds: each candidate runs once per round, so that other load affects all alike.
// Reports the median or the minimum as one JSON object per line for tools/bench.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

namespace weir::bench {

inline double seconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}
inline double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

// Seconds of one run.
struct Cost {
  double wall = 0, cpu = 0;  // cpu: of all threads of the process
};

// Reduces the rounds with `pick`. An additional first round is not counted.
template <class Pick>
std::vector<Cost> over_rounds(const std::vector<std::function<void()>>& candidates, int rounds,
                              Pick pick) {
  std::vector<std::vector<double>> wall(candidates.size()), cpu(candidates.size());
  for (int round = 0; round <= rounds; ++round)
    for (size_t i = 0; i < candidates.size(); ++i) {
      const double wall_before = seconds(CLOCK_MONOTONIC);
      const double cpu_before = seconds(CLOCK_PROCESS_CPUTIME_ID);
      candidates[i]();
      if (round == 0) continue;
      wall[i].push_back(seconds(CLOCK_MONOTONIC) - wall_before);
      cpu[i].push_back(seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu_before);
    }
  std::vector<Cost> out;
  for (size_t i = 0; i < candidates.size(); ++i) out.push_back({pick(wall[i]), pick(cpu[i])});
  return out;
}
inline std::vector<Cost> medians(const std::vector<std::function<void()>>& candidates, int rounds) {
  return over_rounds(candidates, rounds, median);
}
// The minimum, because other load only adds time.
inline std::vector<Cost> min(const std::vector<std::function<void()>>& candidates, int rounds) {
  return over_rounds(candidates, rounds, [](const std::vector<double>& values) {
    return *std::min_element(values.begin(), values.end());
  });
}

// `target`: the limit for `value`; unit: "us", "x", "bytes", "buffers".
inline void report(const std::string& name, const std::string& floor, double value,
                   const char* unit, double target) {
  std::printf(
      "{\"name\": \"%s\", \"floor\": \"%s\", \"value\": %.4f, \"unit\": \"%s\", \"at_most\": %g}\n",
      name.c_str(), floor.c_str(), value, unit, target);
  std::fflush(stdout);
}

}  // namespace weir::bench
