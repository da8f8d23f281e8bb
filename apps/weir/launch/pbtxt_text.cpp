// Names streams and nodes (docs/compatibility/app-api.md 8.3).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "launch/pbtxt_text.hpp"

namespace weir::app {
namespace {

// The second and later elements of a type have their number appended.
std::string stream_name(const LaunchElement& element) {
  return element.number == 0 ? element.type
                             : element.type + "_" + std::to_string(element.number + 1);
}

bool is_source(const LaunchElement& element) {
  return element.inputs.empty();
}

bool is_sink(const LaunchElement& element) {
  return element.outputs.empty();
}

// The name of a link at the end that faces `peer`.
std::string link_name(const LaunchGraph& graph, const LaunchLink& link, const LaunchElement& peer) {
  if (is_source(peer) || is_sink(peer)) return stream_name(peer);
  const LaunchElement& from = graph.elements[link.from];
  return from.type + "_" + std::to_string(from.number) + "_" + std::to_string(link.pad);
}

std::string node(const LaunchGraph& graph, const LaunchElement& element) {
  std::string out = "\nnode: {\n\tcalculator: \"" + element.type + "Calculator\"\n";
  for (const size_t i : element.inputs) {
    const LaunchLink& link = graph.links[i];
    out += "\tinput_stream: \"" + link_name(graph, link, graph.elements[link.from]) + "\"\n";
  }
  for (const size_t i : element.outputs) {
    const LaunchLink& link = graph.links[i];
    out += "\toutput_stream: \"" + link_name(graph, link, graph.elements[link.to]) + "\"\n";
  }
  return out + "}\n";
}

}  // namespace

std::string to_pbtxt(const LaunchGraph& graph) {
  std::string out;
  for (const auto& element : graph.elements)
    if (is_source(element)) out += "input_stream: \"" + stream_name(element) + "\"\n";
  for (const auto& element : graph.elements)
    if (is_sink(element)) out += "output_stream: \"" + stream_name(element) + "\"\n";
  for (const auto& element : graph.elements)
    if (!is_source(element) && !is_sink(element)) out += node(graph, element);
  return out;
}

}  // namespace weir::app
