// `weir pbtxt`: prints a pipeline as a graph (docs/compatibility/app-api.md 8.3).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdio>
#include <iostream>
#include <iterator>

#include "commands.hpp"
#include "launch/launch_graph.hpp"
#include "launch/pbtxt_text.hpp"
#include "report.hpp"
#include "weir/join.hpp"

namespace weir::app {
namespace {

void describe(const LaunchGraph& graph) {
  for (const auto& element : graph.elements)
    std::fprintf(stderr, "element %s (%s): %zu inputs, %zu outputs\n", element.name.c_str(),
                 element.type.c_str(), element.inputs.size(), element.outputs.size());
  for (const auto& link : graph.links)
    std::fprintf(stderr, "link %s ! %s\n", graph.elements[link.from].name.c_str(),
                 graph.elements[link.to].name.c_str());
}

}  // namespace

int pbtxt(const PbtxtOptions& options) {
  if (options.from_pbtxt) {
    std::puts(
        "Converting pbtxt to a pipeline is not implemented; a pipeline can be converted to pbtxt.");
    return kExitGood;
  }
  std::string text = join(options.pipeline, " ");
  if (options.pipeline.empty())
    text.assign(std::istreambuf_iterator<char>(std::cin), std::istreambuf_iterator<char>());
  const auto graph = read_launch_graph(text);
  if (!graph) return report(graph.error(), false);
  if (options.verbose) describe(*graph);
  std::fputs(to_pbtxt(*graph).c_str(), stdout);
  return kExitGood;
}

}  // namespace weir::app
