// Spans: beginnings and ends of one thread paired, with the time of each that is its own.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <string>

#include "core/trace/graph.hpp"
#include "core/trace/recorder.hpp"

namespace weir::trace {

struct Span {
  Kind kind = Kind::PushBegin;  // a beginning
  int64_t begin = 0, end = 0;
  int64_t own = 0;         // without the spans inside
  int64_t between = 0;     // outermost pushes: time since the thread's last span; else 0
  size_t element = kNone;  // where the time is spent: behind the link, or whose state changes
  size_t pad = kNone;      // the pad that pushes, pulls or sends
  int64_t time_stamp = kNoTime;
  uint64_t frames = 0, bytes = 0;
  bool good = false;      // the end was seen and told of no error
  const char* name = "";  // of events and state changes
};

// Calls `f` with each span in the order of their ends. What did not end ends with the last record;
// what did not begin is left out.
void for_each_span(const ThreadRecords& thread, const Graph& graph,
                   const std::function<void(const Span&)>& f);

}  // namespace weir::trace
