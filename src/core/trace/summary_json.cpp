// Writes a Summary as JSON.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <array>
#include <nlohmann/json.hpp>

#include "core/trace/summary.hpp"

namespace weir::trace {
namespace {

using Json = nlohmann::ordered_json;
constexpr size_t kLevels = 400;  // levels of one queue

double seconds(int64_t ns) {
  return static_cast<double>(ns) * 1e-9;
}

Json index(size_t id) {
  return id == kNone ? Json(nullptr) : Json(id);
}

Json to_json(const Flow& flow) {
  return {{"frames", flow.frames}, {"bytes", flow.bytes}, {"rate", flow.rate()}};
}

const char* to_string(Waits waits) {
  constexpr std::array<const char*, 6> kNames{"never", "room",   "clock",
                                              "start", "device", "inputs"};
  return kNames.at(static_cast<size_t>(waits));
}

Json to_json(const Graph& graph, size_t id, const ElementSummary& sums) {
  const Element& element = graph.elements()[id];
  return {{"name", element.name},
          {"factory", element.factory},
          {"bin", element.is_bin},
          {"parent", index(element.parent)},
          {"source", !element.is_bin && !graph.has_pads(id, false)},
          {"sink", !element.is_bin && !graph.has_pads(id, true)},
          {"removed", element.is_removed || element.until != kForEver},
          {"waits", to_string(element.waits)},
          {"in", to_json(sums.in)},
          {"out", to_json(sums.out)},
          {"refused", sums.refused},
          {"work", seconds(sums.work)},
          {"waiting", seconds(sums.waiting)},
          {"longest", seconds(sums.longest)},
          {"events", seconds(sums.events)},
          {"states", seconds(sums.states)},
          {"thread_work", seconds(sums.thread_work)},
          {"thread_waiting", seconds(sums.thread_waiting)}};
}

Json to_json(const LinkSummary& link, const Graph& graph) {
  Json out{{"from", index(graph.owner(link.source_pad))},
           {"from_pad", graph.pads()[link.source_pad].name},
           {"to", index(graph.owner(link.sink_pad))},
           {"to_pad", graph.pads()[link.sink_pad].name},
           {"caps", graph.pads()[link.source_pad].caps},
           {"caps_changes", graph.pads()[link.source_pad].caps_changes}};
  out.update(to_json(link.flow));
  return out;
}

Json to_json(const QueueSummary& queue, const Summary& summary) {
  return {{"element", index(queue.element)},
          {"most", queue.level.max},
          {"mean", queue.level.mean},
          {"fullest", queue.fullest / 1000.0},
          {"not_passed_on", queue.not_passed_on},
          {"levels", highest_levels(queue.level, summary.begin, summary.end, kLevels)}};
}

Json to_json(const StreamLatency& stream, const Graph& graph) {
  const Latency& latency = stream.latency;
  Json buckets = Json::array();
  for (const Bucket& bucket : latency.buckets)
    buckets.push_back(
        {{"from", seconds(bucket.from)}, {"to", seconds(bucket.to)}, {"frames", bucket.frames}});
  return {{"source", index(stream.source)},
          {"origin", index(graph.owner(stream.origin))},
          {"origin_pad", stream.origin == kNone ? "" : graph.pads()[stream.origin].name},
          {"sink", index(stream.sink)},
          {"frames", latency.frames},
          {"unmatched", latency.unmatched},
          {"least", seconds(latency.min)},
          {"mean", seconds(latency.mean)},
          {"median", seconds(latency.median)},
          {"percentile_95", seconds(latency.percentile_95)},
          {"percentile_99", seconds(latency.percentile_99)},
          {"most", seconds(latency.max)},
          {"buckets", std::move(buckets)}};
}

}  // namespace

std::string to_json(const Summary& summary, const Trace& trace) {
  Json out{{"seconds", seconds(summary.end - summary.begin)},
           {"flow_seconds", seconds(summary.flow_end - summary.flow_begin)},
           {"records", summary.records},
           {"lost", summary.lost}};
  for (const char* list : {"elements", "links", "queues", "latencies", "threads"})
    out[list] = Json::array();
  for (size_t i = 0; i < summary.elements.size(); ++i)
    out["elements"].push_back(to_json(trace.graph, i, summary.elements[i]));
  for (const auto& link : summary.links) out["links"].push_back(to_json(link, trace.graph));
  for (const auto& queue : summary.queues) out["queues"].push_back(to_json(queue, summary));
  for (const auto& item : summary.latencies) out["latencies"].push_back(to_json(item, trace.graph));
  for (const auto& thread : trace.threads)
    out["threads"].push_back({{"name", thread.name},
                              {"id", thread.system_id},
                              {"records", thread.records.size()},
                              {"lost", thread.lost}});
  return out.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace weir::trace
