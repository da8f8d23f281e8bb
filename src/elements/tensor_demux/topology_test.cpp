// Branches that are added, removed and stopped while tensor_demux plays; their upstream events.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <future>
#include <thread>

#include "becomes.hpp"
#include "elements/tests/branches_test_support.hpp"

namespace weir::test {
namespace topology_test {

constexpr char kTwo[] =
    "other/tensors,format=static,num_tensors=2,dimensions=(string)\"2,1\",types=(string)\"uint8,"
    "uint8\",framerate=30/1";

GstBuffer* two() {
  return make_frame({{1, 2}, {3}});
}
Ref<GstPad> source_pad(const Branches& demux, const char* name) {
  return Ref<GstPad>::adopt(gst_element_get_static_pad(demux.element(), name));
}

// A bare pad that accepts only these caps.
struct Taker {
  explicit Taker(const char* caps_text) {
    pad = test::lone_sink_pad(caps_text, "taker");
    gst_pad_set_element_private(pad.get(), this);
    gst_pad_set_chain_function(pad.get(), [](GstPad* to, GstObject*, GstBuffer* buffer) {
      ++static_cast<Taker*>(gst_pad_get_element_private(to))->frames;
      gst_buffer_unref(buffer);
      return GST_FLOW_OK;
    });
    gst_pad_set_active(pad.get(), TRUE);
  }
  Taker(const Taker&) = delete;
  Taker& operator=(const Taker&) = delete;
  ~Taker() { gst_pad_set_active(pad.get(), FALSE); }
  std::string caps() const { return test::current_caps(pad.get()); }

  Ref<GstPad> pad;
  int frames = 0;
};

TEST(TensorDemuxTopology, ABranchCanBeReplaced) {
  Branches demux("tensor_demux");
  demux.caps(kTwo);
  ASSERT_EQ(demux.push(two()), GST_FLOW_OK);
  const auto source = source_pad(demux, "src_1");
  EXPECT_SAYS(demux.branch("src_1").caps(), "other/tensors");
  gst_pad_unlink(source.get(), demux.branch("src_1").pad.get());
  EXPECT_EQ(demux.push(two()), GST_FLOW_OK) << "the other branch continues";
  Taker taker("other/tensor");
  ASSERT_EQ(gst_pad_link(source.get(), taker.pad.get()), GST_PAD_LINK_OK);
  EXPECT_EQ(demux.push(two()), GST_FLOW_OK);
  EXPECT_EQ(taker.frames, 1);
  EXPECT_SAYS(taker.caps(), "other/tensor, dimension=(string)1");
  EXPECT_EQ(demux.branch("src_0").buffers.size(), 3u);
  EXPECT_EQ(demux.stat("pushed-src_1"), 3u);
  demux.expect_balance();
}

TEST(TensorDemuxTopology, ReportsABranchThatRejectsTheTensors) {
  Branches demux("tensor_demux");
  demux.caps(kTwo);
  ASSERT_EQ(demux.push(two()), GST_FLOW_OK);
  const auto source = source_pad(demux, "src_1");
  gst_pad_unlink(source.get(), demux.branch("src_1").pad.get());
  Taker taker("other/tensor,type=(string)float32");
  ASSERT_EQ(gst_pad_link_full(source.get(), taker.pad.get(), GST_PAD_LINK_CHECK_NOTHING),
            GST_PAD_LINK_OK);
  EXPECT_EQ(demux.push(two()), GST_FLOW_NOT_NEGOTIATED);
  EXPECT_SAYS(demux.error(),
              "WEIR-2001: the element downstream of src_1 does not accept its output");
  demux.expect_balance();
}

TEST(TensorDemuxTopology, ForwardsDownstreamQueriesAndEventsUpstream) {
  Branches demux("tensor_demux");
  demux.caps(kTwo);
  ASSERT_EQ(demux.push(two()), GST_FLOW_OK);
  const auto sink = Ref<GstPad>::adopt(gst_element_get_static_pad(demux.element(), "sink"));
  const auto upstream = Ref<GstPad>::adopt(gst_pad_get_peer(sink.get()));
  gst_pad_set_query_function(upstream.get(), [](GstPad*, GstObject*, GstQuery* query) -> gboolean {
    if (GST_QUERY_TYPE(query) != GST_QUERY_LATENCY) return FALSE;
    gst_query_set_latency(query, TRUE, 7, 9);
    return TRUE;
  });
  static int qos;
  qos = 0;
  gst_pad_set_event_function(upstream.get(), [](GstPad*, GstObject*, GstEvent* event) -> gboolean {
    qos += GST_EVENT_TYPE(event) == GST_EVENT_QOS;
    gst_event_unref(event);
    return TRUE;
  });
  GstQuery* query = gst_query_new_latency();
  EXPECT_TRUE(gst_pad_peer_query(demux.branch("src_1").pad.get(), query));
  gboolean live = FALSE;
  GstClockTime min = 0, max = 0;
  gst_query_parse_latency(query, &live, &min, &max);
  gst_query_unref(query);
  EXPECT_TRUE(live);
  EXPECT_EQ(min, 7u);
  EXPECT_EQ(max, 9u);
  EXPECT_TRUE(gst_pad_push_event(demux.branch("src_0").pad.get(),
                                 gst_event_new_qos(GST_QOS_TYPE_UNDERFLOW, 1, 0, 0)));
  EXPECT_EQ(qos, 1);
}

TEST(TensorDemuxTopology, FlushesWhilePadsAreMade) {
  for (int round = 0; round < 50; ++round) {
    Branches demux("tensor_demux");
    demux.caps(kTwo);
    std::thread flusher([&] { demux.send(gst_event_new_flush_start()); });
    demux.push(two());
    flusher.join();
    EXPECT_EQ(demux.push(two()), GST_FLOW_FLUSHING);
    demux.send(gst_event_new_flush_stop(TRUE));
    demux.send(test::time_segment());
    EXPECT_EQ(demux.push(two()), GST_FLOW_OK);
    EXPECT_EQ(demux.branch("src_1").buffers.empty(), false);
    demux.expect_balance();
  }
}

// Passes once a segment event has arrived at the pad.
class SegmentSeen {
 public:
  explicit SegmentSeen(GstPad* pad) {
    gst_pad_add_probe(
        pad, GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM,
        [](GstPad*, GstPadProbeInfo* info, gpointer to) {
          if (GST_EVENT_TYPE(GST_PAD_PROBE_INFO_EVENT(info)) != GST_EVENT_SEGMENT)
            return GST_PAD_PROBE_OK;
          static_cast<SegmentSeen*>(to)->seen_.set_value();
          return GST_PAD_PROBE_REMOVE;
        },
        this, nullptr);
  }
  bool wait() { return seen_.get_future().wait_for(kMaxWait) == std::future_status::ready; }

 private:
  std::promise<void> seen_;
};

// Delayed links of gst_parse_launch() work once: a new pipeline for each round.
TEST(TensorDemuxTopology, PipelinesCanStopAtAnyTime) {
  for (int round = 0; round < 20; ++round) {
    const auto pipeline = Ref<GstElement>::adopt(GST_ELEMENT(gst_object_ref_sink(gst_parse_launch(
        "videotestsrc ! video/x-raw,format=GRAY8,width=16,height=8 ! tensor_preprocess "
        "sizes=8x4,4x2 ! tensor_demux name=d tensorpick=1,0:1 d.src_0 ! queue ! tensor_split "
        "name=s tensorseg=1:4:1,1:4:1 s.src_0 ! fakesink d.src_1 ! queue ! tensor_if name=i "
        "compared-value-option=0,0 operator=GE supplied-value=0 i.src_0 ! fakesink",
        nullptr))));
    const auto d = Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline.get()), "d"));
    SegmentSeen segment(Ref<GstPad>::adopt(gst_element_get_static_pad(d.get(), "sink")).get());
    ASSERT_NE(gst_element_set_state(pipeline.get(), GST_STATE_PLAYING), GST_STATE_CHANGE_FAILURE);
    // GStreamer's: a GstBaseTransform that stops between the deactivation of its source pad and
    // that of its sink pad rejects a sticky event, and its source then posts an error (-5). The
    // segment is the last one before the first frame.
    ASSERT_TRUE(segment.wait());
    // Every other round does not wait for the first frame.
    if (round % 2 == 0) {
      ASSERT_EQ(gst_element_get_state(pipeline.get(), nullptr, nullptr, 20 * GST_SECOND),
                GST_STATE_CHANGE_SUCCESS);
      EXPECT_EQ(d.get()->numsrcpads, 2u);
    }
    ASSERT_EQ(gst_element_set_state(pipeline.get(), GST_STATE_READY), GST_STATE_CHANGE_SUCCESS);
    EXPECT_EQ(d.get()->numsrcpads, 0u);
    const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(pipeline.get()));
    const auto error = Ref<GstMessage>::adopt(gst_bus_pop_filtered(bus.get(), GST_MESSAGE_ERROR));
    EXPECT_FALSE(error) << test::get_text(error.get());
    gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  }
}

}  // namespace topology_test
}  // namespace weir::test
