// Loops joined with another stream by tensor_mux: EOS of that stream ends the loop, and an
// unsuitable sync-mode causes a warning.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/pipeline_test_support.hpp"

namespace weir::test {
namespace mux_loop_test {

constexpr char kBytes[] =
    "other/tensor,dimension=(string)1:4:1:1,type=(string)uint8,framerate=30/1";

// White pictures (235 in video range), each muxed with the number of its round.
std::string loop(const std::string& mode, const std::string& between = "") {
  return "videotestsrc pattern=white num-buffers=50 ! "
         "video/x-raw,format=GRAY8,width=4,height=1,framerate=30/1 ! tensor_converter ! " +
         between + "mux.sink_0 tensor_reposrc name=start slot-index=0 caps=" + std::string(kBytes) +
         " ! " + between + "mux.sink_1 tensor_mux name=mux " + mode +
         " ! tensor_transform apply=1 mode=arithmetic option=add:1 ! tee name=t t. ! " + between +
         "tensor_demux tensorpick=1 name=d d.src_0 ! tensor_reposink name=end slot-index=0 t. ! " +
         between + "tensor_sink name=out";
}

void check_rounds(PlayedPipeline& p) {
  EXPECT_EQ(p.plays_to_its_end(), "");
  const auto seen = p.seen<uint8_t>("out");
  ASSERT_EQ(seen.size(), 50u);
  for (size_t i = 0; i < seen.size(); ++i) {
    const auto round = static_cast<uint8_t>(i + 1);
    EXPECT_EQ(seen[i], (Bytes{235, 235, 235, 235, round, round, round, round})) << i;
  }
  EXPECT_EQ(p.stat("end", "received"), 50u);
  EXPECT_EQ(p.stat("start", "held"), 0u);
}

TEST(MuxLoop, EndsWithTheOtherInput) {
  PlayedPipeline p(loop("sync-mode=nosync"));
  p.watch("out");
  check_rounds(p);
}

TEST(MuxLoop, EndsWithQueuesInEachBranch) {
  PlayedPipeline p(loop("sync-mode=nosync", "queue ! "));
  p.watch("out");
  check_rounds(p);
}

TEST(MuxLoop, EndsWhenTheSourceOfTheLoopEndsFirst) {
  PlayedPipeline p(loop("sync-mode=nosync"));
  p.watch("out");
  g_object_set(p.find("start").get(), "num-buffers", 7, nullptr);
  EXPECT_EQ(p.plays_to_its_end(), "");
  EXPECT_EQ(p.seen<uint8_t>("out").size(), 7u);
}

TEST(MuxLoop, CanBeShutDownWhileWaiting) {
  for (const char* mode : {"", "sync-mode=basepad", "sync-mode=refresh", "sync-mode=nosync"}) {
    PlayedPipeline p(loop(mode));
    gst_element_set_state(p.get(), GST_STATE_PLAYING);
    EXPECT_TRUE(p.reaches(GST_STATE_NULL)) << mode;
  }
}

std::string get_warning(const std::string& launch) {
  PlayedPipeline p(launch);
  const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(p.get()));
  gst_element_set_state(p.get(), GST_STATE_PLAYING);
  const auto message = Ref<GstMessage>::adopt(gst_bus_timed_pop_filtered(
      bus.get(), kTimeout, GstMessageType(GST_MESSAGE_WARNING | GST_MESSAGE_EOS)));
  if (!message) return "hangs";
  return GST_MESSAGE_TYPE(message.get()) == GST_MESSAGE_EOS ? "" : get_text(message.get());
}

TEST(MuxLoop, WarnsAboutAnUnsuitableSyncMode) {
  const std::string text = get_warning(loop("sync-mode=slowest", "queue ! "));
  EXPECT_SAYS(text, "WEIR-5001");
  EXPECT_SAYS(text, "a loop goes through mux, which synchronises by timestamps");
  EXPECT_SAYS(text, "offered: sync-mode=slowest");
  EXPECT_SAYS(text, "fix: name=mux sync-mode=nosync");
  EXPECT_SAYS(get_warning(loop("sync-mode=refresh")), "never end");
  EXPECT_EQ(get_warning(loop("sync-mode=nosync")), "");
}

}  // namespace mux_loop_test
}  // namespace weir::test
