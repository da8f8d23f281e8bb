// Converts a pipeline's graph to MediaPipe's text format.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "launch/launch_graph.hpp"

namespace weir::app {

// Precondition: all indices are valid in `graph`, as in the result of read_launch_graph().
std::string to_pbtxt(const LaunchGraph& graph);

}  // namespace weir::app
