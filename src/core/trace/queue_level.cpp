// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/queue_level.hpp"

#include <algorithm>

namespace weir::trace {

QueueLevel queue_level(std::vector<QueueChange> changes, int64_t end) {
  // A sample includes the effect of a push at the same time.
  std::stable_sort(changes.begin(), changes.end(), [](const auto& a, const auto& b) {
    return a.time != b.time ? a.time < b.time : a.sampled < b.sampled;
  });
  QueueLevel out;
  int64_t level = 0;
  double area = 0;
  for (size_t i = 0; i < changes.size(); ++i) {
    // May briefly be below 0: a frame can leave before the push that delivered it has returned.
    level = changes[i].sampled ? changes[i].frames : level + changes[i].frames;
    if (i + 1 < changes.size() && changes[i + 1].time == changes[i].time) continue;
    if (!out.steps.empty())
      area += static_cast<double>(out.steps.back().frames) *
              static_cast<double>(changes[i].time - out.steps.back().time);
    const auto shown = static_cast<uint64_t>(std::max<int64_t>(level, 0));
    out.steps.push_back({changes[i].time, shown});
    out.max = std::max(out.max, shown);
  }
  if (changes.empty() || end <= changes.front().time) return out;
  area += static_cast<double>(out.steps.back().frames) *
          static_cast<double>(std::max<int64_t>(end - out.steps.back().time, 0));
  out.mean = area / static_cast<double>(end - changes.front().time);
  return out;
}

std::vector<uint64_t> highest_levels(const QueueLevel& level, int64_t begin, int64_t end,
                                     size_t count) {
  std::vector<uint64_t> out(count, 0);
  if (end <= begin) return out;
  const double width = static_cast<double>(end - begin) / static_cast<double>(count);
  uint64_t before = 0;
  size_t step = 0;
  for (size_t part = 0; part < count; ++part) {
    const double until = static_cast<double>(begin) + width * static_cast<double>(part + 1);
    out[part] = before;
    for (; step < level.steps.size() &&
           (static_cast<double>(level.steps[step].time) < until || part + 1 == count);
         ++step) {
      before = level.steps[step].frames;
      out[part] = std::max(out[part], before);
    }
  }
  return out;
}

}  // namespace weir::trace
