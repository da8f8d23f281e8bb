// join at the end of its active branch, where another branch has not begun: whole pipelines.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/played_pipeline.hpp"

namespace {

using namespace weir::test;

// Holds all that would leave the queue of branch b until branch a has ended at join.
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

TEST(JoinLateBranch, LosesNoFrameOfAQueueWhoseThreadBeginsAfterTheEnd) {
  PlayedPipeline pipeline(std::string("join name=j ! tensor_sink name=out sync=false ") + kFrames +
                          "queue ! j.sink_0 " + kFrames + "queue name=b ! j.sink_1");
  pipeline.watch("out");
  const LateBranch late(pipeline);
  EXPECT_EQ(pipeline.plays_to_its_end(), "");
  EXPECT_EQ(pipeline.seen<uint8_t>("out").size(), 20u);
}

TEST(JoinLateBranch, LosesNoFrameOfASourceWhoseThreadBeginsAfterTheEnd) {
  PlayedPipeline pipeline(
      std::string("join name=j ! tensor_sink name=out sync=false ") + kFrames +
      "j.sink_0 videotestsrc name=b num-buffers=10 ! video/x-raw,format=GRAY8,width=4,height=4 ! "
      "tensor_converter ! j.sink_1");
  pipeline.watch("out");
  const LateBranch late(pipeline);
  EXPECT_EQ(pipeline.plays_to_its_end(), "");
  EXPECT_EQ(pipeline.seen<uint8_t>("out").size(), 20u);
}

TEST(JoinLateBranch, EndsWhereNothingIsLinkedToTheQueueOfAnotherBranch) {
  PlayedPipeline pipeline(std::string("join name=j ! tensor_sink name=out sync=false ") + kFrames +
                          "j.sink_0 queue name=b ! j.sink_1");
  pipeline.watch("out");
  EXPECT_EQ(pipeline.plays_to_its_end(), "");
  EXPECT_EQ(pipeline.seen<uint8_t>("out").size(), 10u);
}

}  // namespace
