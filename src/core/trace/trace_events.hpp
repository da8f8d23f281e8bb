// Writes a trace in the Trace Event Format, which Perfetto (ui.perfetto.dev) and Chrome's
// about:tracing read.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <ostream>

#include "core/trace/summary.hpp"

namespace weir::trace {

// Complete events ("X") for pushes, pulls, events and state changes, named by the element they go
// to; counters ("C") for the samples of queues; times in microseconds since the first record.
void write_trace_events(const Trace& trace, std::ostream& out);

}  // namespace weir::trace
