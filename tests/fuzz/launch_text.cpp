// Fuzz target: parses pipelines as `weir pbtxt` and nnstreamer-parser do. Every link is listed once
// at each end, elements of a type are numbered from 0, errors have a text.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <string>
#include <string_view>

#include "launch/launch_graph.hpp"
#include "launch/pbtxt_text.hpp"

namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

size_t occurrences(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

void check(const weir::app::LaunchGraph& graph) {
  std::map<std::string, size_t> counts;
  size_t inputs = 0, outputs = 0;
  for (size_t e = 0; e < graph.elements.size(); ++e) {
    const auto& element = graph.elements[e];
    require(!element.type.empty() && element.number == counts[element.type]++);
    inputs += element.inputs.size();
    outputs += element.outputs.size();
    for (const size_t i : element.inputs) require(graph.links.at(i).to == e);
    for (size_t pad = 0; pad < element.outputs.size(); ++pad) {
      const auto& link = graph.links.at(element.outputs[pad]);
      require(link.from == e && link.pad == pad);
    }
  }
  require(!graph.elements.empty());
  require(inputs == graph.links.size() && outputs == graph.links.size());
}

// One line for each link end that is at no pure source or sink, and for each of those.
void check(const weir::app::LaunchGraph& graph, const std::string& text) {
  size_t nodes = 0, streams = 0;
  for (const auto& element : graph.elements) {
    const bool source = element.inputs.empty(), sink = element.outputs.empty();
    if (source || sink) {
      streams += (source ? 1u : 0u) + (sink ? 1u : 0u);
    } else {
      ++nodes;
      streams += element.inputs.size() + element.outputs.size();
    }
  }
  require(occurrences(text, "node: {\n") == nodes);
  require(occurrences(text, "put_stream: \"") == streams);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto graph = weir::app::read_launch_graph(text);
  if (!graph) {
    require(!graph.error().what.empty() && !graph.error().needed.empty());
    return 0;
  }
  check(*graph);
  check(*graph, weir::app::to_pbtxt(*graph));
  return 0;
}
