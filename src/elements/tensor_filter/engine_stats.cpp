// Reads the extensions weir.statistics/1 and weir.servers/1 of an engine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/engine_stats.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "weir/abi.h"

namespace weir {
namespace {

// The counts that the engine has of its own.
void add_counts(const infer::Model& model, GstStructure* stats) {
  const weir_engine& engine = model.engine();
  const auto* calls =
      engine.extension
          ? static_cast<const weir_engine_statistics*>(engine.extension(WEIR_ENGINE_STATISTICS))
          : nullptr;
  if (!calls || calls->struct_size < sizeof *calls) return;
  std::array<weir_statistic, 64> all{};
  const int count = calls->read(model.handle(), all.data(), all.size());
  for (int i = 0; i < std::min<int>(count, all.size()); ++i)
    gst_structure_set(stats, all[i].name, G_TYPE_UINT64, guint64{all[i].value}, nullptr);
}

const char* name_of_circuit(int32_t circuit) {
  if (circuit == WEIR_CIRCUIT_CLOSED) return "closed";
  return circuit == WEIR_CIRCUIT_OPEN ? "open" : "half-open";
}

GstStructure* structure_of(const weir_server& server) {
  GstStructure* out = gst_structure_new(
      "server", "address", G_TYPE_STRING, server.address, "circuit", G_TYPE_STRING,
      name_of_circuit(server.circuit), "in-flight", G_TYPE_UINT64, guint64{server.in_flight},
      "answered", G_TYPE_UINT64, guint64{server.answered}, "late", G_TYPE_UINT64,
      guint64{server.late}, "refused", G_TYPE_UINT64, guint64{server.refused}, "lost",
      G_TYPE_UINT64, guint64{server.lost}, "bytes-sent", G_TYPE_UINT64, guint64{server.bytes_sent},
      "bytes-received", G_TYPE_UINT64, guint64{server.bytes_received}, nullptr);
  const auto add = [out](const char* name, int64_t value, bool is_known) {
    if (is_known) gst_structure_set(out, name, G_TYPE_INT64, gint64{value}, nullptr);
  };
  for (const auto& [name, value] : {std::pair{"p50-us", server.p50_us},
                                    {"p95-us", server.p95_us},
                                    {"p99-us", server.p99_us},
                                    {"queue-us", server.queue_us},
                                    {"compute-us", server.compute_us}})
    add(name, value, value >= 0);
  add("clock-offset-ns", server.clock_offset_ns, server.clock_error_ns >= 0);
  add("clock-error-ns", server.clock_error_ns, server.clock_error_ns >= 0);
  return out;
}

// The servers that the model is on, as an array of structures.
void add_servers(const infer::Model& model, GstStructure* stats) {
  const auto* calls = model.servers();
  if (!calls) return;
  std::array<weir_server, 64> all{};
  const int count = calls->read(model.handle(), all.data(), all.size());
  if (count <= 0) return;
  GValue list = G_VALUE_INIT;
  gst_value_array_init(&list, static_cast<guint>(count));
  for (int i = 0; i < std::min<int>(count, all.size()); ++i) {
    GValue one = G_VALUE_INIT;
    g_value_init(&one, GST_TYPE_STRUCTURE);
    g_value_take_boxed(&one, structure_of(all[i]));
    gst_value_array_append_and_take_value(&list, &one);
  }
  gst_structure_take_value(stats, "servers", &list);
}

}  // namespace

void add_engine_stats(const infer::Model& model, GstStructure* stats) {
  add_counts(model, stats);
  add_servers(model, stats);
}

}  // namespace weir
