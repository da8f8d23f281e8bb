// Writes a trace in the Trace Event Format for Perfetto (ui.perfetto.dev) and Chrome's
// about:tracing.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <ostream>

#include "core/trace/summary.hpp"

namespace weir::trace {

// Writes complete events ("X") for pushes, pulls, events and state changes, named after the element
// they go to, and counters ("C") for queue samples. Times are microseconds since the first record.
void write_trace_events(const Trace& trace, std::ostream& out);

}  // namespace weir::trace
