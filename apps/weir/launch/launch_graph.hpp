// LaunchGraph: the elements and links of a pipeline's text, parsed without GStreamer, so that
// elements need not be installed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "weir/result.hpp"

namespace weir::app {

struct LaunchElement {
  std::string type, name;  // name: name=, or GStreamer's default, "tee0"
  size_t number = 0;       // counts elements of this type from 0
  size_t at = 0;           // offset in the text
  // Indices of links, in text order.
  std::vector<size_t> inputs, outputs;
};

// A pad that the text names, as src_0 in "demux.src_0".
struct LaunchPad {
  std::string name;  // "": any
  size_t at = 0;     // offset of the name in the text
};

struct LaunchLink {
  size_t from = 0, to = 0;  // indices of elements
  size_t pad = 0;           // index of the output of `from`
  size_t at = 0;            // offset in the text of the downstream end
  size_t caps_at = 0;       // offset of the caps before it, such as "video/x-raw"; `at` if none
  LaunchPad from_pad, to_pad;
};

// Caps between two elements belong to the link. Bins, "( a ! b )", are flattened.
struct LaunchGraph {
  std::vector<LaunchElement> elements;  // in text order
  std::vector<LaunchLink> links;
};

// OPTION_SYNTAX with a caret below the place; LIMIT_EXCEEDED above 1 MiB.
Result<LaunchGraph> read_launch_graph(std::string_view text);

}  // namespace weir::app
