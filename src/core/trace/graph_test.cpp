// Reused addresses, links over time, and ghost pads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/graph.hpp"

#include <gtest/gtest.h>

#include "core/trace/trace_test_support.hpp"

namespace weir::trace {
namespace graph_test {

using Edges = std::vector<Edge>;

TEST(TraceGraph, AReusedAddressIsANewElement) {
  Graph graph;
  graph.name_element(at(1), nullptr, "first", "f", false, 10);
  EXPECT_TRUE(graph.destroyed(at(1), 20));
  graph.name_element(at(1), nullptr, "second", "f", false, 30);
  EXPECT_EQ(graph.elements()[graph.element_at(at(1), 15)].name, "first");
  EXPECT_EQ(graph.elements()[graph.element_at(at(1), 35)].name, "second");
  EXPECT_EQ(graph.element_at(at(1), 5), kNone);
  EXPECT_EQ(graph.element_at(at(1), 25), kNone);
  EXPECT_EQ(graph.element_at(at(2), 15), kNone);
}

TEST(TraceGraph, AnElementMayBeNamedAfterItsPadsWereSeen) {
  Graph graph;
  const size_t pad = graph.see_pad(at(2), at(1), "src", true, 10);
  graph.name_element(at(1), at(9), "late", "f", false, 20);
  EXPECT_EQ(graph.elements()[graph.owner(pad)].name, "late");
  EXPECT_EQ(graph.elements()[graph.owner(pad)].parent, graph.element_at(at(9), 20));
  EXPECT_TRUE(graph.has_pads(graph.owner(pad), true));
  EXPECT_FALSE(graph.has_pads(graph.owner(pad), false));
}

TEST(TraceGraph, APeerIsTheOneAtThatTime) {
  Graph graph;
  add_element(&graph, 10, "a", false, true);
  add_element(&graph, 20, "b", true, false);
  add_element(&graph, 30, "c", true, false);
  graph.link(at(12), at(21), 100);
  graph.unlink(at(12), at(21), 200);
  graph.link(at(12), at(31), 300);
  const size_t source = graph.pad_at(at(12), 0);
  EXPECT_EQ(graph.peer_at(source, 99), kNone);
  EXPECT_EQ(graph.peer_at(source, 100), graph.pad_at(at(21), 0));
  EXPECT_EQ(graph.peer_at(source, 250), kNone);
  EXPECT_EQ(graph.peer_at(source, 300), graph.pad_at(at(31), 0));
  EXPECT_EQ(graph.edges().size(), 2u);
}

TEST(TraceGraph, LinksOfPadsThatWereNeverSeenAreLeftOut) {
  Graph graph;
  add_element(&graph, 10, "a", false, true);
  graph.link(at(12), at(21), 100);
  graph.join_halves(at(12), at(77));
  EXPECT_FALSE(graph.destroyed(at(99), 100));
  EXPECT_EQ(graph.edges(), Edges{});
  EXPECT_EQ(graph.peer_at(kNone, 100), kNone);
}

// a ! bin(b ! c) ! d: two ghost pads, each with an inner half.
TEST(TraceGraph, EdgesFollowGhostPadsOfBins) {
  Graph graph;
  for (const auto& [address, name] :
       {std::pair<uintptr_t, const char*>{10, "a"}, {20, "b"}, {30, "c"}, {40, "d"}})
    add_element(&graph, address, name, name[0] != 'a', name[0] != 'd');
  graph.name_element(at(50), nullptr, "bin", "bin", true, 0);
  graph.see_pad(at(51), at(50), "sink", false, 0);
  graph.see_pad(at(52), at(50), "src", true, 0);
  graph.see_pad(at(61), nullptr, "half", true, 0);
  graph.see_pad(at(62), nullptr, "half", false, 0);
  graph.join_halves(at(51), at(61));
  graph.join_halves(at(52), at(62));
  graph.link(at(12), at(51), 1);
  graph.link(at(61), at(21), 1);
  graph.link(at(22), at(31), 1);
  graph.link(at(32), at(62), 1);
  graph.link(at(52), at(41), 1);
  const auto pad = [&](uintptr_t address) { return graph.pad_at(at(address), 1); };
  EXPECT_EQ(graph.edges(),
            (Edges{{pad(12), pad(21), true}, {pad(22), pad(31), true}, {pad(32), pad(41), true}}));
  EXPECT_EQ(graph.end_at(pad(12), 1), pad(21));
  EXPECT_EQ(graph.end_at(pad(32), 1), pad(41));
  EXPECT_EQ(graph.end_at(pad(12), 0), kNone);
  EXPECT_EQ(graph.owner(pad(62)), graph.element_at(at(50), 1));
}

// As decodebin does: its ghost pad first shows the demuxer, then the decoder that it plugged.
TEST(TraceGraph, AGhostPadThatMovesToAnotherElementLinksEachForItsTime) {
  Graph graph;
  for (const auto& [address, name] :
       {std::pair<uintptr_t, const char*>{10, "demuxer"}, {20, "decoder"}, {30, "sink"}})
    add_element(&graph, address, name, address != 10, address != 30);
  graph.see_pad(at(52), at(50), "src", true, 0);
  graph.see_pad(at(62), nullptr, "half", false, 0);
  graph.join_halves(at(52), at(62));
  graph.link(at(12), at(62), 100);
  graph.unlink(at(12), at(62), 200);
  graph.link(at(12), at(21), 210);
  graph.link(at(22), at(62), 220);
  graph.link(at(52), at(31), 300);
  const auto pad = [&](uintptr_t address) { return graph.pad_at(at(address), 1000); };
  EXPECT_EQ(graph.edges(), (Edges{{pad(12), pad(21), true}, {pad(22), pad(31), true}}));
  EXPECT_EQ(graph.end_at(pad(12), 150), kNone);
  EXPECT_EQ(graph.end_at(pad(22), 400), pad(31));
}

TEST(TraceGraph, AnEdgeEndsWithItsPads) {
  Graph graph;
  add_element(&graph, 10, "a", false, true);
  add_element(&graph, 20, "b", true, false);
  graph.link(at(12), at(21), 100);
  const size_t source = graph.pad_at(at(12), 100), sink = graph.pad_at(at(21), 100);
  graph.destroyed(at(21), 200);
  EXPECT_EQ(graph.edges(), (Edges{{source, sink, false}}));
}

TEST(TraceGraph, GhostPadsInACircleMakeNoEdge) {
  Graph graph;
  add_element(&graph, 10, "a", false, true);
  for (const uintptr_t base : {50, 60}) {
    graph.see_pad(at(base), at(90), "sink", false, 0);
    graph.see_pad(at(base + 1), nullptr, "half", true, 0);
    graph.join_halves(at(base), at(base + 1));
  }
  graph.link(at(12), at(50), 1);
  graph.link(at(51), at(60), 1);
  graph.link(at(61), at(50), 1);
  EXPECT_EQ(graph.edges(), Edges{});
  EXPECT_EQ(graph.end_at(graph.pad_at(at(12), 1), 1), kNone);
}

TEST(TraceGraph, AnUnlinkedGhostPadMakesNoEdge) {
  Graph graph;
  add_element(&graph, 10, "a", false, true);
  graph.see_pad(at(51), at(50), "sink", false, 0);
  graph.see_pad(at(61), nullptr, "half", true, 0);
  graph.join_halves(at(51), at(61));
  graph.link(at(12), at(51), 1);
  EXPECT_EQ(graph.edges(), Edges{});
}

}  // namespace graph_test
}  // namespace weir::trace
