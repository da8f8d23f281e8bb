// Whole loops: their output, how they end, and that no order of states or events blocks them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <array>

#include "elements/tests/pipeline_test_support.hpp"

namespace weir::test {
namespace loop_test {

constexpr char kCaps[] =
    " caps=other/tensor,dimension=(string)4:1:1:1,type=(string)int32,framerate=(fraction)0/1 ";
constexpr char kAddOne[] = " ! tensor_transform mode=arithmetic option=add:1 ";

std::string text(int number) {
  return std::to_string(number);
}
// Four numbers that grow by 1 each round. The reposink is linked before the tensor_sink and must
// not block the tensor_sink's first frame.
std::string counting(int slot, const std::string& more, const std::string& sink = "out") {
  const std::string tee = "t" + text(slot);
  return "tensor_reposrc slot-index=" + text(slot) + kCaps + more + kAddOne + "! tee name=" + tee +
         " " + tee + ". ! tensor_reposink name=end" + text(slot) + " slot-index=" + text(slot) +
         " " + tee + ". ! tensor_sink name=" + sink + " ";
}
std::vector<std::vector<int32_t>> count_to(int32_t last) {
  std::vector<std::vector<int32_t>> all;
  for (int32_t i = 1; i <= last; ++i) all.push_back({i, i, i, i});
  return all;
}

TEST(Loop, CountsItsRoundsAndKeepsWhatItShowed) {
  PlayedPipeline p(counting(0, "num-buffers=1000"));
  p.watch("out");
  EXPECT_EQ(p.plays_to_its_end(), "");
  EXPECT_EQ(p.seen<int32_t>("out"), count_to(1000))
      << "frames in progress do not share their memory";
  EXPECT_EQ(p.stat("end0", "received"), 1000u);
  EXPECT_EQ(p.stat("end0", "consumed"), 999u);
  EXPECT_EQ(p.stat("end0", "held"), 1u) << "the last one, which the source no longer read";
}

TEST(Loop, WorksWithTheSinkWrittenFirst) {
  PlayedPipeline p(std::string("tensor_reposink name=end slot-index=7 tensor_sink name=out "
                               "tensor_reposrc slot-index=7 num-buffers=20") +
                   kCaps + kAddOne + "! tee name=t ! end. t. ! out.");
  p.watch("out");
  EXPECT_EQ(p.plays_to_its_end(), "");
  EXPECT_EQ(p.seen<int32_t>("out"), count_to(20));
}

TEST(Loop, RunsWithQueuesInIt) {
  PlayedPipeline p(std::string("tensor_reposrc slot-index=0 num-buffers=200") + kCaps + "! queue" +
                   kAddOne +
                   "! tee name=t ! queue ! tensor_reposink slot-index=0 t. ! queue ! "
                   "tensor_sink name=out");
  p.watch("out");
  EXPECT_EQ(p.plays_to_its_end(), "");
  EXPECT_EQ(p.seen<int32_t>("out"), count_to(200));
}

TEST(Loop, SeveralRunInOnePipelineAndInSeveral) {
  PlayedPipeline one(counting(0, "num-buffers=100", "a") + counting(1, "num-buffers=150", "b"));
  PlayedPipeline other(counting(2, "num-buffers=200", "c"));
  for (const char* name : {"a", "b"}) one.watch(name);
  other.watch("c");
  gst_element_set_state(one.get(), GST_STATE_PLAYING);
  EXPECT_EQ(other.plays_to_its_end(), "");
  EXPECT_EQ(one.outcome(), "");
  EXPECT_EQ(one.seen<int32_t>("a"), count_to(100));
  EXPECT_EQ(one.seen<int32_t>("b"), count_to(150));
  EXPECT_EQ(other.seen<int32_t>("c"), count_to(200));
}

// Two loops in series: each feeds the other.
TEST(Loop, CanUseTwoSlots) {
  PlayedPipeline p(std::string("tensor_reposrc slot-index=0 num-buffers=50") + kCaps + kAddOne +
                   "! tensor_reposink slot-index=1 tensor_reposrc slot-index=1" + kCaps + kAddOne +
                   "! tee name=t ! tensor_reposink slot-index=0 t. ! tensor_sink name=out");
  p.watch("out");
  EXPECT_EQ(p.plays_to_its_end(), "");
  const auto seen = p.seen<int32_t>("out");
  ASSERT_GE(seen.size(), 40u);
  // Two frames circulate, the zeros of each source. They pass here in turn, and each round both
  // transforms add 1; in its first round the second source's frame passed only the second
  // transform.
  for (size_t i = 0; i < seen.size(); ++i) EXPECT_EQ(seen[i][0], static_cast<int32_t>(i + 1)) << i;
}

TEST(Loop, EndsWithEosFromAnElementInside) {
  PlayedPipeline p(std::string("tensor_reposrc slot-index=0") + kCaps + kAddOne +
                   "! identity eos-after=31 ! tee name=t ! tensor_reposink slot-index=0 t. ! "
                   "tensor_sink name=out");
  p.watch("out");
  EXPECT_EQ(p.plays_to_its_end(), "");
  EXPECT_EQ(p.seen<int32_t>("out"), count_to(30));
}

TEST(Loop, EndsWithEosOfThePipeline) {
  PlayedPipeline p(counting(0, ""));
  EXPECT_TRUE(p.reaches(GST_STATE_PLAYING));
  EXPECT_TRUE(gst_element_send_event(p.get(), gst_event_new_eos()));
  EXPECT_EQ(p.outcome(), "");
}

TEST(Loop, ContinuesAfterAPause) {
  PlayedPipeline p(counting(0, "num-buffers=3000"));
  p.watch("out");
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(p.reaches(GST_STATE_PLAYING));
    EXPECT_TRUE(p.reaches(GST_STATE_PAUSED));
  }
  EXPECT_EQ(p.plays_to_its_end(), "");
  EXPECT_EQ(p.seen<int32_t>("out"), count_to(3000));
}

TEST(Loop, StartsWithZerosWhenPlayedAgain) {
  PlayedPipeline p(counting(0, "num-buffers=10"));
  for (int i = 0; i < 3; ++i) {
    p.watch("out");
    EXPECT_EQ(p.plays_to_its_end(), "");
    EXPECT_TRUE(p.reaches(GST_STATE_READY));
    EXPECT_EQ(p.seen<int32_t>("out").at(0), (std::vector<int32_t>{1, 1, 1, 1}));
  }
}

TEST(Loop, IsRestartedByAFlush) {
  PlayedPipeline p(counting(0, ""));
  EXPECT_TRUE(p.reaches(GST_STATE_PLAYING));
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(gst_element_send_event(p.get(), gst_event_new_flush_start()));
    EXPECT_TRUE(gst_element_send_event(p.get(), gst_event_new_flush_stop(TRUE)));
  }
  // The flush set the sink to PAUSED. GstBaseSrc handles EOS after its push returns, the push waits
  // for PLAYING, and PLAYING waits for the lock under which a bin sends EOS: GStreamer's own
  // elements (1.22) deadlock in the same way.
  EXPECT_TRUE(p.reaches(GST_STATE_PLAYING));
  EXPECT_TRUE(gst_element_send_event(p.get(), gst_event_new_eos()));
  EXPECT_EQ(p.outcome(), "");
}

// The elements go to NULL one by one, in each order and from each state.
TEST(Loop, CanBeShutDownInAnyStateAndOrder) {
  for (const GstState state : {GST_STATE_READY, GST_STATE_PAUSED, GST_STATE_PLAYING}) {
    std::array<const char*, 4> order{"add", "between", "end", "start"};
    do {
      PlayedPipeline p(std::string("tensor_reposrc name=start slot-index=0") + kCaps +
                       "! queue name=between ! tensor_transform name=add mode=arithmetic "
                       "option=add:1 ! tensor_reposink name=end slot-index=0");
      EXPECT_TRUE(p.reaches(state));
      for (const char* name : order) {
        const auto element = p.find(name);
        gst_element_set_locked_state(element.get(), TRUE);
        EXPECT_EQ(gst_element_set_state(element.get(), GST_STATE_NULL), GST_STATE_CHANGE_SUCCESS);
      }
    } while (std::next_permutation(order.begin(), order.end()));
  }
}

// Both indices change while frames circulate: the sink's first, or the source's first.
TEST(Loop, MovesToAnotherSlotWhilePlaying) {
  PlayedPipeline p(std::string("tensor_reposrc name=start slot-index=0") + kCaps + kAddOne +
                   "! tee name=t ! tensor_reposink name=end slot-index=0 t. ! "
                   "tensor_sink name=out");
  EXPECT_TRUE(p.reaches(GST_STATE_PLAYING));
  const auto start = p.find("start"), end = p.find("end");
  for (guint i = 1; i < 200; ++i) {
    g_object_set((i % 2 ? start : end).get(), "slot-index", i, nullptr);
    g_object_set((i % 2 ? end : start).get(), "slot-index", i, nullptr);
  }
  EXPECT_TRUE(gst_element_send_event(p.get(), gst_event_new_eos()));
  EXPECT_EQ(p.outcome(), "");
}

TEST(Loop, ReportsASinkWhoseFramesDoNotFit) {
  PlayedPipeline p(std::string("tensor_reposrc slot-index=0") + kCaps +
                   "! tensor_transform mode=typecast option=float32 ! tensor_reposink");
  const std::string error = p.plays_to_its_end();
  EXPECT_SAYS(error, "WEIR-2001");
  EXPECT_SAYS(error, "type is float32, needed is int32");
}

}  // namespace loop_test
}  // namespace weir::test
