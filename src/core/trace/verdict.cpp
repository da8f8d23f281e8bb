// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/verdict.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "weir/join.hpp"

namespace weir::trace {
namespace {

// An element with this share of the time limits a pipeline that does not wait for a clock or a
// device, and with the second one any pipeline.
constexpr double kHalf = 0.5, kNearlyAll = 0.8;
// A pipeline that waits this much for a clock or a device has time left.
constexpr double kMuchWaiting = 0.2;
constexpr size_t kListed = 3;  // elements of a balanced pipeline

std::string percent(double share) {
  return std::to_string(std::lround(share * 100)) + " %";
}

std::string frames(uint64_t count) {
  return std::to_string(count) + (count == 1 ? " frame" : " frames");
}

Verdict failed(const Failure& failure) {
  const std::string subject = failure.element.empty() ? "The pipeline" : failure.element;
  return {VerdictKind::Failed, failure.element, 0,
          subject + " failed: " + failure.what + (failure.what.ends_with('.') ? "" : ".")};
}

// The last element with frames that pushed none; else a source that pushed none.
Verdict nothing_ran(const std::vector<Load>& loads) {
  const std::string none = "No frame reached a sink";
  for (const Load& load : loads)
    if (load.in > 0 && load.out == 0 && !load.is_sink)
      return {VerdictKind::NothingRan, load.name, 0,
              none + ": " + load.name + " received " + frames(load.in) + " and pushed none."};
  for (const Load& load : loads)
    if (load.is_source && load.out == 0)
      return {VerdictKind::NothingRan, load.name, 0,
              none + ": the source " + load.name + " pushed none."};
  return {VerdictKind::NothingRan, "", 0, none + "."};
}

Verdict limited_by(const Load& load) {
  const std::string takes = load.name + " takes " + percent(load.work) + " of the time: ";
  if (load.is_source)
    return {VerdictKind::SourceBound, load.name, load.work,
            "The source " + takes + "the bottleneck."};
  if (load.is_sink)
    return {VerdictKind::SinkBound, load.name, load.work, "The sink " + takes + "the bottleneck."};
  return {VerdictKind::Bottleneck, load.name, load.work, takes + "the bottleneck."};
}

bool waits_for_time(const Load& load) {
  return load.waits == Waits::Clock || load.waits == Waits::Device;
}

Verdict keeps_up(const Load& paced, const Load& busiest) {
  const std::string what = paced.waits == Waits::Device
                               ? "The pipeline keeps up with its live source " + paced.name +
                                     ", for which it waits " + percent(paced.waiting)
                               : "The pipeline keeps up with real time: " + paced.name +
                                     " waits for the clock " + percent(paced.waiting);
  return {VerdictKind::KeepsUp, busiest.name, busiest.work,
          what + " of the time. The busiest element is " + busiest.name + " with " +
              percent(busiest.work) + "."};
}

Verdict balanced(std::vector<Load> loads) {
  std::stable_sort(loads.begin(), loads.end(),
                   [](const Load& a, const Load& b) { return a.work > b.work; });
  std::vector<std::string> max;
  for (const Load& load : loads)
    if (max.size() < kListed && load.work > 0) max.push_back(load.name + " " + percent(load.work));
  if (max.empty()) return {VerdictKind::Balanced, "", 0, "No element takes a measurable time."};
  return {VerdictKind::Balanced, loads.front().name, loads.front().work,
          "No element takes most of the time; the busiest: " + join(max, ", ") + "."};
}

}  // namespace

Verdict judge(const std::vector<Load>& loads, const std::vector<Failure>& failures) {
  if (!failures.empty()) return failed(failures.front());
  const bool any_arrived = std::any_of(
      loads.begin(), loads.end(), [](const Load& load) { return load.is_sink && load.in > 0; });
  if (!any_arrived) return nothing_ran(loads);
  const Load& busiest = *std::max_element(
      loads.begin(), loads.end(), [](const Load& a, const Load& b) { return a.work < b.work; });
  const auto waiting = [](const Load& load) { return waits_for_time(load) ? load.waiting : 0; };
  const Load& paced = *std::max_element(
      loads.begin(), loads.end(),
      [&waiting](const Load& a, const Load& b) { return waiting(a) < waiting(b); });
  const bool has_time = waiting(paced) >= kMuchWaiting;
  if (busiest.work >= (has_time ? kNearlyAll : kHalf)) return limited_by(busiest);
  return has_time ? keeps_up(paced, busiest) : balanced(loads);
}

std::string to_string(VerdictKind kind) {
  constexpr std::array<const char*, 7> kNames{
      "failed", "nothing-ran", "bottleneck", "source-bound", "sink-bound", "keeps-up", "balanced"};
  return kNames.at(static_cast<size_t>(kind));
}

}  // namespace weir::trace
