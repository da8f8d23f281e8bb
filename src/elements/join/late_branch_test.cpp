// join in pipelines where the active branch ends before another branch has started.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <chrono>

#include "elements/tests/pipeline_test_support.hpp"

namespace late_branch_test {

using namespace weir::test;

// Blocks the output of branch b's queue until branch a has reached EOS at join.
class LateBranch {
 public:
  explicit LateBranch(const PlayedPipeline& pipeline)
      : b_(Ref<GstPad>::adopt(gst_element_get_static_pad(pipeline.find("b").get(), "src"))) {
    const auto a =
        Ref<GstPad>::adopt(gst_element_get_static_pad(pipeline.find("j").get(), "sink_0"));
    held_ = gst_pad_add_probe(
        b_.get(), GST_PAD_PROBE_TYPE_BLOCK_DOWNSTREAM,
        +[](GstPad*, GstPadProbeInfo*, gpointer) { return GST_PAD_PROBE_OK; }, nullptr, nullptr);
    gst_pad_add_probe(a.get(), GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM, on_event, this, nullptr);
  }

 private:
  static GstPadProbeReturn on_event(GstPad*, GstPadProbeInfo* info, gpointer user) {
    auto* late = static_cast<LateBranch*>(user);
    if (GST_EVENT_TYPE(GST_PAD_PROBE_INFO_EVENT(info)) == GST_EVENT_EOS)
      gst_pad_remove_probe(late->b_.get(), late->held_);
    return GST_PAD_PROBE_OK;
  }

  Ref<GstPad> b_;
  gulong held_ = 0;
};

constexpr char kFrames[] =
    "videotestsrc num-buffers=10 ! video/x-raw,format=GRAY8,width=4,height=4 ! tensor_converter ! ";

TEST(JoinLateBranch, KeepsFramesOfAQueueThatStartsAfterEos) {
  PlayedPipeline pipeline(std::string("join name=j ! tensor_sink name=out sync=false ") + kFrames +
                          "queue ! j.sink_0 " + kFrames + "queue name=b ! j.sink_1");
  pipeline.watch("out");
  const LateBranch late(pipeline);
  EXPECT_EQ(pipeline.plays_to_its_end(), "");
  EXPECT_EQ(pipeline.seen<uint8_t>("out").size(), 20u);
}

TEST(JoinLateBranch, KeepsFramesOfASourceThatStartsAfterEos) {
  PlayedPipeline pipeline(
      std::string("join name=j ! tensor_sink name=out sync=false ") + kFrames +
      "j.sink_0 videotestsrc name=b num-buffers=10 ! video/x-raw,format=GRAY8,width=4,height=4 ! "
      "tensor_converter ! j.sink_1");
  pipeline.watch("out");
  const LateBranch late(pipeline);
  EXPECT_EQ(pipeline.plays_to_its_end(), "");
  EXPECT_EQ(pipeline.seen<uint8_t>("out").size(), 20u);
}

TEST(JoinLateBranch, EndsWhenTheQueueOfAnotherBranchIsUnlinked) {
  PlayedPipeline pipeline(std::string("join name=j ! tensor_sink name=out sync=false ") + kFrames +
                          "j.sink_0 queue name=b ! j.sink_1");
  pipeline.watch("out");
  EXPECT_EQ(pipeline.plays_to_its_end(), "");
  EXPECT_EQ(pipeline.seen<uint8_t>("out").size(), 10u);
}

constexpr char kIf[] =
    "tensor_if name=i compared-value=A_VALUE compared-value-option=0:0:0:0,0 operator=GE "
    "supplied-value=0 ";

// The time between EOS of element `a`'s branch and EOS of join.
std::chrono::nanoseconds end_takes(const std::string& branches, size_t frames) {
  PlayedPipeline pipeline(std::string("join name=j ! tensor_sink name=out sync=false ") + kFrames +
                          branches);
  pipeline.watch("out");
  std::chrono::steady_clock::time_point ends[2];
  const auto watch = [&](const char* element, const char* name, size_t which) {
    const auto pad =
        Ref<GstPad>::adopt(gst_element_get_static_pad(pipeline.find(element).get(), name));
    gst_pad_add_probe(
        pad.get(), GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM,
        +[](GstPad*, GstPadProbeInfo* info, gpointer end) {
          if (GST_EVENT_TYPE(GST_PAD_PROBE_INFO_EVENT(info)) == GST_EVENT_EOS)
            *static_cast<std::chrono::steady_clock::time_point*>(end) =
                std::chrono::steady_clock::now();
          return GST_PAD_PROBE_OK;
        },
        &ends[which], nullptr);
  };
  watch("a", "sink", 0);
  watch("j", "src", 1);
  EXPECT_EQ(pipeline.plays_to_its_end(), "");
  EXPECT_EQ(pipeline.seen<uint8_t>("out").size(), frames);
  return ends[1] - ends[0];
}

// Without the wait of a second for a branch that may still bring a frame. A busy machine may delay
// some of the attempts.
bool ends_at_once(const std::string& branches, size_t frames) {
  for (int i = 0; i < 5; ++i)
    if (end_takes(branches, frames) < std::chrono::milliseconds(900)) return true;
  return false;
}

TEST(JoinLateBranch, EndsImmediatelyWhenTheQueueOfAnotherBranchStaysEmpty) {
  const std::string stays_empty = "identity name=a ! j.sink_0 i.src_1 ! queue ! j.sink_1";
  EXPECT_TRUE(ends_at_once(kIf + ("i.src_0 ! " + stays_empty), 10));
  // This one sends no stream-start to a branch that it does not select.
  EXPECT_TRUE(ends_at_once("output-selector name=i i.src_0 ! " + stays_empty, 10));
}

TEST(JoinLateBranch, EndsImmediatelyAfterTwoChainedQueues) {
  const std::string chain = "identity name=a ! j.sink_0 i.src_1 ! queue ! queue ! j.sink_1";
  EXPECT_TRUE(ends_at_once("output-selector name=i i.src_0 ! " + chain, 10));
  EXPECT_TRUE(ends_at_once(kIf + ("i.src_0 ! " + chain), 10));
  EXPECT_TRUE(ends_at_once("tee name=i i.src_0 ! " + chain, 20));
}

TEST(JoinLateBranch, KeepsFramesOfAQueueFilledByTheSameThread) {
  PlayedPipeline pipeline(std::string("join name=j ! tensor_sink name=out sync=false ") + kFrames +
                          "tee name=t ! j.sink_0 t. ! queue name=b ! j.sink_1");
  pipeline.watch("out");
  const LateBranch late(pipeline);
  EXPECT_EQ(pipeline.plays_to_its_end(), "");
  EXPECT_EQ(pipeline.seen<uint8_t>("out").size(), 20u);
}

TEST(JoinLateBranch, KeepsFramesOfTwoChainedQueues) {
  PlayedPipeline pipeline(std::string("join name=j ! tensor_sink name=out sync=false ") + kFrames +
                          "tee name=t ! j.sink_0 t. ! queue ! queue name=b ! j.sink_1");
  pipeline.watch("out");
  const LateBranch late(pipeline);
  EXPECT_EQ(pipeline.plays_to_its_end(), "");
  EXPECT_EQ(pipeline.seen<uint8_t>("out").size(), 20u);
}

}  // namespace late_branch_test
