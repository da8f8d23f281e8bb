// Spans: pairs of begin and end records of one thread, with the time spent in each one itself.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <string>

#include "core/trace/graph.hpp"
#include "core/trace/recorder.hpp"

namespace weir::trace {

struct Span {
  Kind kind = Kind::PushBegin;  // a begin kind
  int64_t begin = 0, end = 0;
  int64_t own = 0;      // excludes nested spans
  int64_t between = 0;  // outermost pushes: time since the thread's last span; else 0
  // The part of `own` and `between` in which the thread did not run; 0 where it was not measured.
  int64_t own_idle = 0, between_idle = 0;
  // Where the time is spent: the linked peer, or the element that changes state.
  size_t element = kNone;
  size_t pad = kNone;  // the pad that pushes, pulls or sends
  int64_t time_stamp = kNoTime;
  uint64_t frames = 0, bytes = 0;
  bool good = false;      // the end was recorded without an error
  const char* name = "";  // of events and state changes
};

// Calls `f` with each span in the order of their ends. A span without an end ends with the last
// record; an end without a begin is ignored.
void for_each_span(const ThreadRecords& thread, const Graph& graph,
                   const std::function<void(const Span&)>& f);

}  // namespace weir::trace
