// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/readings.hpp"

#include <algorithm>
#include <iterator>
#include <string_view>

#include "core/heads/families.hpp"
#include "core/heads/head_options.hpp"
#include "core/text/text.hpp"

namespace weir::heads {

uint32_t stated_tasks(const ModelSignature& facts) {
  constexpr std::pair<std::string_view, uint32_t> kStated[] = {
      {"detect", kDetection},
      {"obb", kDetection},
      {"segment", kDetection | kSegmentation},
      {"pose", kDetection | kPose},
      {"classify", kClassification}};
  const auto stated = metadata(facts, "task");
  uint32_t all = 0;
  for (const auto& [name, task] : kReadingModes) all |= task;
  for (const auto& [name, tasks] : kStated)
    if (equal_ignoring_case(stated, name)) return tasks;
  return all;
}

std::vector<Reading> list_readings(const ModelSignature& facts, uint32_t tasks) {
  std::vector<Reading> out;
  for (const auto& [name, task] : kReadingModes) {
    if (!(tasks & task)) continue;
    for (const Family* family : fitting(facts, task)) {
      const bool is_known = std::any_of(
          out.begin(), out.end(), [&](const Reading& other) { return other.family == family; });
      if (!is_known) out.push_back({name, family});
    }
  }
  // One list of scores is a class of the picture, not a text of one step.
  const auto has = [&](std::string_view name) {
    return std::any_of(out.begin(), out.end(),
                       [&](const Reading& r) { return r.family->name == name; });
  };
  if (has("classifier"))
    std::erase_if(out, [](const Reading& r) { return r.family->name == "ctc"; });
  return out;
}

std::vector<Reading> likely(const std::vector<Reading>& readings, const ModelSignature& facts) {
  const auto chosen = [&](auto is_chosen) {
    std::vector<Reading> out;
    std::copy_if(readings.begin(), readings.end(), std::back_inserter(out), is_chosen);
    return out;
  };
  auto out = chosen([&](const Reading& r) { return r.family->fit(facts) == Match::Certain; });
  if (out.empty())
    out = chosen([&](const Reading& r) {
      const uint32_t tasks = r.family->tasks;
      const auto points = points_of_heat_maps(facts);
      if (r.family == &kHeatMaps && !is_usual_of_points(points)) return false;
      // As many labels as maps may name classes, or points.
      if (r.family == &kDeepLab && points > 0 && points == facts.labels) return true;
      return (tasks & (kDetection | kPose)) != 0 && (tasks & kText) == 0;
    });
  return out.empty() ? readings : out;
}

std::optional<Reading> only_reading(const ModelSignature& facts) try {
  const auto readings = likely(list_readings(facts, stated_tasks(facts)), facts);
  return readings.size() == 1 ? std::optional(readings[0]) : std::nullopt;
} catch (const Failure&) {
  return std::nullopt;  // outputs that no head takes
}

}  // namespace weir::heads
