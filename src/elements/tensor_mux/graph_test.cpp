// tensor_mux in whole pipelines: branches that merge, with and without queues; loops.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <string>

#include "elements/tests/pipeline_test_support.hpp"

namespace weir::test {
namespace graph_test {

constexpr char kSource[] =
    "videotestsrc num-buffers=10 ! video/x-raw,format=GRAY8,width=4,height=4,framerate=30/1 ! "
    "tensor_converter ! ";

using Graph = test::PlayedPipeline;

TEST(TensorMuxGraph, CombinesBranchesWithQueues) {
  for (const char* mode : {"nosync", "slowest", "basepad", "refresh"}) {
    Graph graph(std::string(kSource) +
                "tee name=t  t. ! queue ! mux.sink_1  t. ! queue ! mux.sink_0  tensor_mux name=mux "
                "sync-mode=" +
                mode + " ! tensor_sink name=out");
    EXPECT_EQ(graph.plays_to_its_end(), "") << mode;
    EXPECT_EQ(graph.stat("mux", "received"), 20u) << mode;
    EXPECT_GE(graph.stat("out", "received"), 10u) << mode;
    EXPECT_EQ(graph.stat("mux", "held"), 0u) << mode;
  }
}

TEST(TensorMuxGraph, ReportsWhereQueuesAreMissing) {
  Graph graph(std::string(kSource) +
              "tee name=t  t. ! mux.sink_0  t. ! tensor_transform name=mul mode=arithmetic "
              "option=mul:2 ! mux.sink_1  tensor_mux name=mux ! fakesink");
  const std::string error = graph.plays_to_its_end();
  EXPECT_SAYS(error, "WEIR-5001");
  EXPECT_SAYS(error, "sink_0 and sink_1 of mux");
  EXPECT_SAYS(error, "through t ");
  EXPECT_SAYS(error, "t. ! queue ! mux.sink_0   t. ! queue ! mul ! mux.sink_1");
}

// Two threads feed the first mux. Each pushes its output and blocks where the branches merge.
TEST(TensorMuxGraph, ReportsMissingQueuesDownstreamOfAnotherMux) {
  const std::string first =
      std::string(kSource) + "first. " + kSource + "first. tensor_mux name=first ! ";
  for (const char* branches : {"tee name=t t. ! mux.sink_0 t. ! mux.sink_1 ",
                               "tee name=t t. ! mux.sink_0 t. ! identity ! mux.sink_1 ",
                               "tensor_demux name=t t.src_0 ! mux.sink_0 t.src_1 ! mux.sink_1 "}) {
    Graph graph(first + branches + "tensor_mux name=mux ! fakesink");
    const std::string error = graph.plays_to_its_end();
    EXPECT_SAYS(error, "WEIR-5001");
    EXPECT_SAYS(error, "sink_0 and sink_1 of mux, both fed through t ");
    EXPECT_SAYS(error, "t. ! queue ! mux.sink_0");
  }
}

TEST(TensorMuxGraph, CombinesBranchesWithQueuesDownstreamOfAnotherMux) {
  Graph graph(std::string(kSource) + "first. " + kSource +
              "first. tensor_mux name=first ! tensor_demux name=d d.src_0 ! queue ! mux.sink_0 "
              "d.src_1 ! mux.sink_1 tensor_mux name=mux ! tensor_sink name=out");
  EXPECT_EQ(graph.plays_to_its_end(), "");
  EXPECT_EQ(graph.stat("out", "received"), 10u);
}

TEST(TensorMuxGraph, AQueueInOneOfTwoBranchesIsEnough) {
  Graph graph(std::string(kSource) +
              "tee name=t  t. ! queue ! mux.sink_0  t. ! mux.sink_1  tensor_mux name=mux ! "
              "tensor_sink name=out");
  EXPECT_EQ(graph.plays_to_its_end(), "");
  EXPECT_EQ(graph.stat("out", "received"), 10u);
}

TEST(TensorMuxGraph, FindsBranchesInsideABin) {
  Graph graph(std::string(kSource) +
              "tee name=t  t. ! mux.sink_0  t. ! ( identity ) ! mux.sink_1  "
              "tensor_mux name=mux ! fakesink");
  const std::string error = graph.plays_to_its_end();
  EXPECT_SAYS(error, "WEIR-5001");
}

TEST(TensorMuxGraph, ReportsHowToBreakALoop) {
  for (const char* between : {"identity", "queue"}) {
    Graph graph(std::string(kSource) +
                "mux.sink_0  tensor_mux name=mux ! tee name=t  t. ! queue "
                "! fakesink  t. ! " +
                between + " ! mux.sink_1");
    const std::string error = graph.plays_to_its_end();
    EXPECT_SAYS(error, "WEIR-5001");
    EXPECT_SAYS(error, "tensor_reposink");
    EXPECT_SAYS(error, "sink_1");
  }
}

// Each mux has its own source and also waits for the other.
TEST(TensorMuxGraph, ReportsHowToBreakALoopThroughTwoMuxes) {
  Graph graph(std::string(kSource) + "a.sink_0  " + kSource +
              "b.sink_0  tensor_mux name=a ! tee name=x x. ! queue ! fakesink x. ! queue ! "
              "b.sink_1  tensor_merge name=b ! tee name=y y. ! queue ! fakesink y. ! queue ! "
              "a.sink_1");
  const std::string error = graph.plays_to_its_end();
  EXPECT_SAYS(error, "WEIR-5001");
  EXPECT_SAYS(error, "sink_1 of ");
  EXPECT_SAYS(error, "tensor_reposink");
}

TEST(TensorMuxGraph, TwoSourcesNeedNoQueue) {
  Graph graph(std::string(kSource) + "mux.  " + kSource +
              "mux.  tensor_mux name=mux ! tensor_sink name=out");
  EXPECT_EQ(graph.plays_to_its_end(), "");
  EXPECT_EQ(graph.stat("out", "received"), 10u);
}

}  // namespace graph_test
}  // namespace weir::test
