// LaunchGraph: the elements and links of a pipeline's text, read without GStreamer: elements need
// not be installed.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "weir/result.hpp"

namespace weir::app {

struct LaunchElement {
  std::string type, name;  // name: name=, or as GStreamer would give one, "tee0"
  size_t number = 0;       // among the elements of its type, from 0
  // Indices of links, in the text's order.
  std::vector<size_t> inputs, outputs;
};

struct LaunchLink {
  size_t from = 0, to = 0;  // indices of elements
  size_t pad = 0;           // which of the outputs of `from`
};

// Caps between two elements belong to the link. Bins, "( a ! b )", are only what they hold.
struct LaunchGraph {
  std::vector<LaunchElement> elements;  // in the text's order
  std::vector<LaunchLink> links;
};

// OPTION_SYNTAX with a caret below the place. LIMIT_EXCEEDED beyond 1 MiB.
Result<LaunchGraph> read_launch_graph(std::string_view text);

}  // namespace weir::app
