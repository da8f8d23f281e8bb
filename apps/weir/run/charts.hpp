// Charts as SVG: a level over time, a histogram.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "report.hpp"

namespace weir::app {

// `queue`: an item of summary["queues"]; `seconds`: the duration of the run.
std::string level_chart(const Json& queue, double seconds);
// `latency`: an item of summary["latencies"] with frames.
std::string histogram(const Json& latency);

}  // namespace weir::app
