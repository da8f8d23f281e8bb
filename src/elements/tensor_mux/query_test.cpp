// A tee upstream of tensor_mux, and caps or links that change while the mux waits for one branch:
// an ALLOCATION query must not wait for the thread that waits in the mux.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/app/gstappsrc.h>

#include <condition_variable>
#include <mutex>

#include "elements/tests/pipeline_test_support.hpp"

namespace weir::test {
namespace query_test {

// Counts the frames that pass a pad.
class Passed {
 public:
  void watch(GstPad* pad) {
    gst_pad_add_probe(
        pad, GST_PAD_PROBE_TYPE_BUFFER,
        [](GstPad*, GstPadProbeInfo*, gpointer self) {
          static_cast<Passed*>(self)->one();
          return GST_PAD_PROBE_OK;
        },
        this, nullptr);
  }
  bool reaches(int frames) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kMaxWait, [&] { return frames_ >= frames; });
  }

 private:
  void one() {
    std::lock_guard lock(mutex_);
    ++frames_;
    changed_.notify_all();
  }

  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  int frames_ = 0;
};

// One branch of a tee pushes frames to the mux, the other none while its valve is closed: the mux
// holds the first frame of the first branch.
class OneBranchWaits {
 public:
  // `before` is upstream of the tee, `branch` is part of each branch.
  explicit OneBranchWaits(const std::string& before, const std::string& branch = "")
      : pipeline_("appsrc name=feed format=time ! " + before + " ! tee name=t t. ! queue ! " +
                  branch +
                  "mux.sink_0 t. ! queue ! valve name=valve drop=true "
                  "drop-mode=forward-sticky-events ! " +
                  branch + "mux.sink_1 tensor_mux name=mux ! tensor_sink async=false"),
        tee_(pipeline_.find("t")) {
    watch(tee_.get(), "sink", &at_tee_);
    watch(pipeline_.find("mux").get(), "sink_0", &waiting_);
    gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING);
  }
  ~OneBranchWaits() { open(); }
  OneBranchWaits(const OneBranchWaits&) = delete;
  OneBranchWaits& operator=(const OneBranchWaits&) = delete;

  void push(int width, int frames) {
    for (int i = 0; i < frames; ++i) push(width);
  }
  bool reach_the_tee(int frames) { return at_tee_.reaches(frames); }
  bool one_waits() { return waiting_.reaches(1); }
  void relink() {
    const auto sink = Ref<GstElement>::share(gst_element_factory_make("fakesink", nullptr));
    g_object_set(sink.get(), "async", FALSE, nullptr);
    gst_bin_add(GST_BIN(pipeline_.get()), sink.get());
    gst_element_sync_state_with_parent(sink.get());
    gst_element_link(tee_.get(), sink.get());
  }
  void open() { g_object_set(pipeline_.find("valve").get(), "drop", FALSE, nullptr); }
  std::string end() {
    gst_app_src_end_of_stream(GST_APP_SRC(pipeline_.find("feed").get()));
    return pipeline_.outcome();
  }

 private:
  static void watch(GstElement* element, const char* pad, Passed* by) {
    by->watch(Ref<GstPad>::adopt(gst_element_get_static_pad(element, pad)).get());
  }
  void push(int width) {
    const auto buffer = Ref<GstBuffer>::adopt(frame(ramp(static_cast<size_t>(width) * 4 * 8)));
    GST_BUFFER_PTS(buffer.get()) = pushed_ * GST_MSECOND;
    GST_BUFFER_DURATION(buffer.get()) = GST_MSECOND;
    ++pushed_;
    const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(
        ("video/x-raw,format=RGBA,width=" + std::to_string(width) + ",height=8,framerate=1000/1")
            .c_str()));
    const Unique<GstSample, gst_sample_unref> sample(
        gst_sample_new(buffer.get(), caps.get(), nullptr, nullptr));
    gst_app_src_push_sample(GST_APP_SRC(pipeline_.find("feed").get()), sample.get());
  }

  Passed at_tee_, waiting_;
  PlayedPipeline pipeline_;
  Ref<GstElement> tee_;
  guint64 pushed_ = 0;
};

struct Case {
  const char* name;
  int frames;  // combined to one upstream of the tee
  const char* before;
  const char* branch;
};
void PrintTo(const Case& c, std::ostream* out) {
  *out << c.before;
}
class WaitingMux : public ::testing::TestWithParam<Case> {};

TEST_P(WaitingMux, CapsChangeUpstreamOfTheTee) {
  OneBranchWaits graph(GetParam().before, GetParam().branch);
  graph.push(8, GetParam().frames);
  ASSERT_TRUE(graph.one_waits());
  graph.push(16, GetParam().frames);
  EXPECT_TRUE(graph.reach_the_tee(2)) << "the query waits for the mux";
  graph.open();
  graph.push(16, GetParam().frames);
  EXPECT_EQ(graph.end(), "");
}

TEST_P(WaitingMux, ABranchIsLinkedDownstreamOfTheTee) {
  OneBranchWaits graph(GetParam().before, GetParam().branch);
  graph.push(8, GetParam().frames);
  ASSERT_TRUE(graph.one_waits());
  graph.relink();
  graph.push(8, GetParam().frames);
  EXPECT_TRUE(graph.reach_the_tee(2)) << "the query waits for the mux";
  graph.open();
  graph.push(8, GetParam().frames);
  EXPECT_EQ(graph.end(), "");
}

INSTANTIATE_TEST_SUITE_P(
    Elements, WaitingMux,
    ::testing::Values(
        Case{"Converter", 1, "tensor_converter", ""},
        Case{"Transform", 1, "tensor_converter ! tensor_transform mode=transpose option=1:0:2:3",
             ""},
        Case{"Aggregator", 2, "tensor_converter ! tensor_aggregator frames-out=2 frames-dim=3", ""},
        Case{"Sparse", 1, "tensor_converter ! tensor_sparse_enc ! tensor_sparse_dec", ""},
        Case{"Preprocess", 1, "tensor_preprocess width=4 height=4", ""},
        Case{"Decoder", 1, "tensor_converter ! tensor_decoder mode=direct_video ! video/x-raw",
             "tensor_converter ! "}),
    [](const auto& info) { return std::string(info.param.name); });

}  // namespace query_test
}  // namespace weir::test
