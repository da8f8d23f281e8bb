// A pipeline's graph in MediaPipe's text format.
#pragma once
#include <string>

#include "launch_graph.hpp"

namespace weir::app {

// Precondition: indices of links and elements are those of `graph`, as read_launch_graph gives
// them.
std::string pbtxt_of(const LaunchGraph& graph);

}  // namespace weir::app
