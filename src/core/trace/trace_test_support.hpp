// Test helpers: hand-made records and graphs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "core/trace/summary.hpp"

namespace weir::trace {

// Addresses are only compared, so any number will do.
inline const void* at(uintptr_t number) {
  return reinterpret_cast<const void*>(number);
}

inline Record record(Kind kind, int64_t time, uintptr_t object, int64_t value = 0,
                     uint64_t frames = 0, uint64_t bytes = 0) {
  Record out;
  out.kind = static_cast<unsigned>(kind) & 15U;
  out.time = time;
  out.object = at(object);
  out.value = value;
  out.frames = frames & kMaxFrames;
  out.bytes = bytes & kMaxBytes;
  return out;
}

inline Record push(int64_t time, uintptr_t pad, int64_t time_stamp = kNoTime, uint64_t bytes = 10) {
  return record(Kind::PushBegin, time, pad, time_stamp, 1, bytes);
}
inline Record pushed(int64_t time, uintptr_t pad, int64_t result = 0) {
  return record(Kind::PushEnd, time, pad, result);
}
inline Record named(Kind kind, int64_t time, uintptr_t object, const char* name) {
  Record out = record(kind, time, object);
  out.name = name;
  return out;
}

// An element at `address`; optionally with a sink pad at address + 1 and a source pad at address +
// 2.
inline void add_element(Graph* graph, uintptr_t address, const std::string& name, bool sink,
                        bool source) {
  graph->name_element(at(address), nullptr, name, "factory-of-" + name, false, 0);
  if (sink) graph->see_pad(at(address + 1), at(address), "sink", false, 0);
  if (source) graph->see_pad(at(address + 2), at(address), "src", true, 0);
}

// source (10) ! middle (20) ! sink (30)
inline Graph chain_of_three() {
  Graph graph;
  add_element(&graph, 10, "source", false, true);
  add_element(&graph, 20, "middle", true, true);
  add_element(&graph, 30, "sink", true, false);
  graph.link(at(12), at(21), 0);
  graph.link(at(22), at(31), 0);
  return graph;
}

}  // namespace weir::trace
