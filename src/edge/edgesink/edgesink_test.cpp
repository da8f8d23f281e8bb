// edgesink with protocol=local: buffers through shared memory, and receivers that come and go.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/video/gstvideometa.h>

#include <optional>
#include <thread>

#include "edge/edge_local_test_support.hpp"
#include "elements/tests/pipeline_test_support.hpp"
#include "gstcpp/buffer/query_meta.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"
#include "transport/local/subscriber.hpp"

namespace edgesink_test {

using namespace weir::test;

TEST_F(EdgeLocal, BuffersArriveWithBytesTimesAndFlags) {
  const auto out = sink();
  const auto in = source();
  ASSERT_TRUE(receivers_become(out, 1));
  GstBuffer* sent = frame(Bytes{1, 2, 3, 4}, 40, 20);
  GST_BUFFER_DTS(sent) = 30;
  GST_BUFFER_OFFSET(sent) = 7;
  GST_BUFFER_OFFSET_END(sent) = 8;
  GST_BUFFER_FLAG_SET(sent, GST_BUFFER_FLAG_MARKER);
  ASSERT_EQ(gst_harness_push(out.get(), sent), GST_FLOW_OK);
  const auto got = pull(in);
  ASSERT_TRUE(got);
  EXPECT_EQ(content(got.get()), (Bytes{1, 2, 3, 4}));
  EXPECT_EQ(GST_BUFFER_PTS(got.get()), 40u);
  EXPECT_EQ(GST_BUFFER_DTS(got.get()), 30u);
  EXPECT_EQ(GST_BUFFER_DURATION(got.get()), 20u);
  EXPECT_EQ(GST_BUFFER_OFFSET(got.get()), 7u);
  EXPECT_EQ(GST_BUFFER_OFFSET_END(got.get()), 8u);
  EXPECT_TRUE(GST_BUFFER_FLAG_IS_SET(got.get(), GST_BUFFER_FLAG_MARKER));
  EXPECT_SAYS(caps_text(in), "other/tensor, dimension=(string)4");
}

TEST_F(EdgeLocal, EachMemoryStaysOne) {
  const auto out = sink();
  const auto in = source();
  ASSERT_TRUE(receivers_become(out, 1));
  GstBuffer* sent = frame(Bytes{1, 2, 3, 4});
  gst_buffer_append_memory(sent, make_memory({5, 6}));
  gst_buffer_append_memory(sent, make_memory(ramp(1000)));
  gst_harness_push(out.get(), sent);
  const auto got = pull(in);
  ASSERT_EQ(gst_buffer_n_memory(got.get()), 3u);
  EXPECT_EQ(content(gst_buffer_peek_memory(got.get(), 1)), (Bytes{5, 6}));
  EXPECT_EQ(content(gst_buffer_peek_memory(got.get(), 2)), ramp(1000));
  EXPECT_EQ(stat(out, "edgesink", "bytes-copied"), 1006u);
}

// The allocator that edgesink proposes gives memory that the receiver maps.
TEST_F(EdgeLocal, ABufferOfTheProposedAllocatorIsNotCopied) {
  const auto out = sink();
  const auto in = source();
  ASSERT_TRUE(receivers_become(out, 1));
  const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(kLocalCaps));
  const Unique<GstQuery, gst_query_unref> query(gst_query_new_allocation(caps.get(), FALSE));
  ASSERT_TRUE(gst_pad_peer_query(out->srcpad, query.get()));
  ASSERT_EQ(gst_query_get_n_allocation_params(query.get()), 1u);
  GstAllocator* raw = nullptr;
  GstAllocationParams params;
  gst_query_parse_nth_allocation_param(query.get(), 0, &raw, &params);
  const auto allocator = Ref<GstAllocator>::adopt(raw);
  GstBuffer* sent = gst_buffer_new_allocate(allocator.get(), 4, &params);
  gst_buffer_fill(sent, 0, "\x09\x08\x07\x06", 4);
  gst_buffer_append_memory(sent, make_memory({5}));  // and one that is not of the allocator
  gst_harness_push(out.get(), sent);
  const auto got = pull(in);
  EXPECT_EQ(content(gst_buffer_peek_memory(got.get(), 0)), (Bytes{9, 8, 7, 6}));
  EXPECT_EQ(content(gst_buffer_peek_memory(got.get(), 1)), (Bytes{5}));
  EXPECT_EQ(stat(out, "edgesink", "bytes-copied"), 1u);
}

TEST_F(EdgeLocal, ElementsUpstreamWriteIntoSharedMemory) {
  const auto in = source("reconnect=true");
  const auto pipeline = lone_element(
      "videotestsrc num-buffers=20 ! video/x-raw,format=RGB,width=64,height=48 ! "
      "tensor_converter ! tensor_transform mode=typecast option=float32 ! "
      "edgesink name=out sync=false wait-connection=true" +
      ends_with());
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  for (int i = 0; i < 20; ++i) {
    const auto got = pull(in);
    ASSERT_TRUE(got) << i;
    EXPECT_EQ(gst_buffer_get_size(got.get()), 64u * 48 * 3 * 4);
  }
  const auto out = Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline.get()), "out"));
  EXPECT_TRUE(wait_for_stat(out.get(), "consumed", 20));
  EXPECT_EQ(stat(out.get(), "bytes-copied"), 0u);
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
}

TEST_F(EdgeLocal, MetasOfResultsTravel) {
  const auto out = sink();
  const auto in = source();
  ASSERT_TRUE(receivers_become(out, 1));
  GstBuffer* sent = frame(Bytes{1, 2, 3, 4});
  auto* region = gst_buffer_add_video_region_of_interest_meta(sent, "cat", 1, 2, 3, 4);
  region->id = 5;
  region->parent_id = 6;
  gst_video_region_of_interest_meta_add_param(
      region, gst_structure_new("detection", "confidence", G_TYPE_DOUBLE, 0.5, nullptr));
  weir::gst::set_client(sent, 1234567890123);
  weir::SourceMap map;
  map.xx = 2.5;
  map.source_width = 640;
  map.row = 9;
  weir::gst::set_source_maps(sent, {map, map}, weir::gst::MapsOf::Regions);
  gst_harness_push(out.get(), sent);

  const auto got = pull(in);
  auto* arrived = gst_buffer_get_video_region_of_interest_meta_id(got.get(), 5);
  ASSERT_TRUE(arrived);
  EXPECT_STREQ(g_quark_to_string(arrived->roi_type), "cat");
  EXPECT_EQ(arrived->parent_id, 6);
  EXPECT_EQ((std::vector{arrived->x, arrived->y, arrived->w, arrived->h}),
            (std::vector{1u, 2u, 3u, 4u}));
  gdouble confidence = 0;
  const auto* detection = gst_video_region_of_interest_meta_get_param(arrived, "detection");
  ASSERT_TRUE(detection);
  gst_structure_get_double(detection, "confidence", &confidence);
  EXPECT_EQ(confidence, 0.5);
  EXPECT_EQ(weir::gst::get_client_id(got.get()), 1234567890123);
  const auto maps = weir::gst::source_maps(got.get());
  ASSERT_EQ(maps.size(), 2u);
  EXPECT_EQ(maps[1].xx, 2.5);
  EXPECT_EQ(maps[1].source_width, 640u);
  EXPECT_EQ(maps[1].row, 9u);
  EXPECT_EQ(weir::gst::maps_of(got.get()), weir::gst::MapsOf::Regions);
}

TEST_F(EdgeLocal, SoManyRegionsTravelThatTheyNeedAMemory) {
  const auto out = sink();
  const auto in = source();
  ASSERT_TRUE(receivers_become(out, 1));
  GstBuffer* sent = frame(Bytes{1, 2, 3, 4});
  for (int i = 0; i < 1000; ++i) {
    auto* region = gst_buffer_add_video_region_of_interest_meta(sent, "face", 1, 2, 3, 4);
    region->id = i;
    gst_video_region_of_interest_meta_add_param(
        region, gst_structure_new("detection", "score", G_TYPE_DOUBLE, 0.1, nullptr));
  }
  gst_harness_push(out.get(), sent);
  const auto got = pull(in);
  EXPECT_EQ(gst_buffer_get_n_meta(got.get(), GST_VIDEO_REGION_OF_INTEREST_META_API_TYPE), 1000u);
  EXPECT_EQ(content(got.get()), (Bytes{1, 2, 3, 4}));
}

TEST_F(EdgeLocal, CapsChangeInTheMiddle) {
  const auto out = sink();
  const auto in = source();
  ASSERT_TRUE(receivers_become(out, 1));
  gst_harness_push(out.get(), frame(Bytes{1, 2, 3, 4}));
  EXPECT_EQ(content(pull(in).get()), (Bytes{1, 2, 3, 4}));
  EXPECT_SAYS(caps_text(in), "dimension=(string)4");
  gst_harness_set_src_caps_str(
      out.get(), "other/tensor,dimension=(string)2,type=(string)uint8,framerate=30/1");
  gst_harness_push(out.get(), frame(Bytes{5, 6}));
  EXPECT_EQ(content(pull(in).get()), (Bytes{5, 6}));
  EXPECT_SAYS(caps_text(in), "dimension=(string)2");
}

TEST_F(EdgeLocal, TheEndArrives) {
  const auto out = sink();
  const auto in = source();
  ASSERT_TRUE(receivers_become(out, 1));
  gst_harness_push(out.get(), frame(Bytes{1, 2, 3, 4}));
  gst_harness_push_event(out.get(), gst_event_new_eos());
  EXPECT_TRUE(pull(in));
  EXPECT_TRUE(becomes_true(
      [&] {
        const auto event = Ref<GstEvent>::adopt(gst_harness_try_pull_event(in.get()));
        return event && GST_EVENT_TYPE(event.get()) == GST_EVENT_EOS;
      },
      "EOS"));
}

TEST_F(EdgeLocal, WithoutAReceiverBuffersAreDroppedAndCounted) {
  const auto out = sink();
  for (int i = 0; i < 3; ++i) gst_harness_push(out.get(), frame(Bytes{1, 2, 3, 4}));
  EXPECT_EQ(stat(out, "edgesink", "received"), 3u);
  EXPECT_EQ(stat(out, "edgesink", "dropped-policy"), 3u);
  EXPECT_EQ(stat(out, "edgesink", "bytes-copied"), 0u);
}

// A receiver that keeps its frames.
class Keeper {
 public:
  explicit Keeper(const std::string& path) {
    auto made = weir::local::Subscriber::connect(path);
    EXPECT_TRUE(made) << (made ? "" : made.error().message());
    if (made) subscriber_.emplace(*std::move(made));
  }
  // The first byte of the next frame.
  int keep_next() {
    for (;;) {
      auto event = subscriber_->receive();
      if (!event || event->kind == weir::local::StreamEvent::Kind::Lost) return -1;
      if (!event->frame) continue;
      kept_.push_back(event->frame);
      return static_cast<int>(event->frame->memories[0][0]);
    }
  }
  void release() { kept_.clear(); }

 private:
  std::optional<weir::local::Subscriber> subscriber_;
  std::vector<std::shared_ptr<const weir::local::ReceivedFrame>> kept_;
};

TEST_F(EdgeLocal, AReceiverThatIsFullMissesBuffersWithDrop) {
  const auto out = sink("drop=true max-buffers=2");
  Keeper keeper(path());
  for (uint8_t i = 0; i < 5; ++i) gst_harness_push(out.get(), frame(Bytes{i, 0, 0, 0}));
  EXPECT_EQ(keeper.keep_next(), 0);
  EXPECT_EQ(keeper.keep_next(), 1);
  EXPECT_EQ(stat(out, "edgesink", "consumed"), 2u);
  EXPECT_EQ(stat(out, "edgesink", "dropped-policy"), 3u);
  EXPECT_EQ(stat(out, "edgesink", "missed"), 3u);
  keeper.release();
  ASSERT_TRUE(becomes_true(
      [&] {
        gst_harness_push(out.get(), frame(Bytes{9, 0, 0, 0}));
        return stat(out, "edgesink", "consumed") == 3;
      },
      "the release"));
  EXPECT_EQ(keeper.keep_next(), 9);
}

TEST_F(EdgeLocal, StoppingEndsTheWaitForAFullReceiver) {
  const auto out = sink("max-buffers=1");
  Keeper keeper(path());
  gst_harness_push(out.get(), frame(Bytes{1, 2, 3, 4}));
  std::thread writer([&] {
    EXPECT_EQ(gst_harness_push(out.get(), frame(Bytes{5, 6, 7, 8})), GST_FLOW_FLUSHING);
  });
  EXPECT_TRUE(wait_for_stat(out, "edgesink", "received", 2));
  gst_element_set_state(find_element(out, "edgesink").get(), GST_STATE_NULL);
  writer.join();
}

TEST_F(EdgeLocal, PausingWhileAReceiverIsFullLosesAndRepeatsNothing) {
  const auto out = sink("max-buffers=1");
  Keeper keeper(path());
  gst_harness_push(out.get(), frame(Bytes{1, 2, 3, 4}));
  EXPECT_EQ(keeper.keep_next(), 1);
  std::thread writer([&] {
    EXPECT_EQ(gst_harness_push(out.get(), frame(Bytes{5, 6, 7, 8})), GST_FLOW_OK);
  });
  EXPECT_TRUE(wait_for_stat(out, "edgesink", "received", 2));
  const auto element = find_element(out, "edgesink");
  for (int i = 0; i < 200; ++i) {  // some before the thread that waits has woken
    gst_element_set_state(element.get(), GST_STATE_PAUSED);
    gst_element_set_state(element.get(), GST_STATE_PLAYING);
  }
  keeper.release();
  EXPECT_EQ(keeper.keep_next(), 5);
  writer.join();
  EXPECT_EQ(stat(out, "edgesink", "consumed"), 2u);
}

// The buffer after the flush has the address of the one before it, if that one was freed.
TEST_F(EdgeLocal, AFlushForgetsTheBufferThatWaited) {
  const auto out = sink("max-buffers=1");
  Keeper keeper(path());
  gst_harness_push(out.get(), frame(Bytes{1, 2, 3, 4}));
  EXPECT_EQ(keeper.keep_next(), 1);
  GstBuffer* const waiting = frame(Bytes{5, 6, 7, 8});
  std::thread writer([&] { EXPECT_EQ(gst_harness_push(out.get(), waiting), GST_FLOW_FLUSHING); });
  EXPECT_TRUE(wait_for_stat(out, "edgesink", "received", 2));
  gst_harness_push_event(out.get(), gst_event_new_flush_start());
  writer.join();
  gst_harness_push_event(out.get(), gst_event_new_flush_stop(TRUE));
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  gst_harness_push_event(out.get(), gst_event_new_segment(&segment));
  keeper.release();
  std::vector<Ref<GstBuffer>> others;
  GstBuffer* next = frame(Bytes{9, 0, 0, 0});
  for (int i = 0; i < 1000 && next != waiting; ++i) {
    others.push_back(Ref<GstBuffer>::adopt(next));
    next = frame(Bytes{9, 0, 0, 0});
  }
  EXPECT_EQ(gst_harness_push(out.get(), next), GST_FLOW_OK);
  EXPECT_EQ(keeper.keep_next(), 9);
}

// The stream's thread may begin to wait before the change to PLAYING has returned.
TEST_F(EdgeLocal, StatesChangeWhileItWaitsForAReceiver) {
  const PlayedPipeline pipeline(
      "videotestsrc ! video/x-raw,format=GRAY8,width=4,height=1 ! "
      "edgesink sync=false wait-connection=true connection-timeout=20000" +
      ends_with());
  Errors errors(pipeline.get());
  for (int i = 0; i < 200; ++i) {
    ASSERT_TRUE(pipeline.reaches(GST_STATE_PLAYING)) << i;
    ASSERT_TRUE(pipeline.reaches(GST_STATE_PAUSED)) << i;
    ASSERT_TRUE(pipeline.reaches(GST_STATE_PLAYING)) << i;
    ASSERT_TRUE(pipeline.reaches(GST_STATE_READY)) << i;
  }
  EXPECT_EQ(errors.next(), "");
}

TEST_F(EdgeLocal, WaitConnectionGivesUpAfterItsTimeout) {
  const auto out = sink("wait-connection=true connection-timeout=1");
  Errors errors(out);
  EXPECT_EQ(gst_harness_push(out.get(), frame(Bytes{1, 2, 3, 4})), GST_FLOW_ERROR);
  const std::string error = errors.next();
  EXPECT_SAYS(error, "no receiver connected");
  EXPECT_SAYS(error, "connection-timeout=1 ms");
}

TEST_F(EdgeLocal, ErrorsAtTheStartNameTheFix) {
  EXPECT_SAYS(start_error("edgesink protocol=local"), "it is empty");
  EXPECT_SAYS(start_error("edgesink protocol=local path=/nonexistent/a"), "No such file");
  EXPECT_SAYS(start_error("edgesrc protocol=local path=" + folder_ + "/none"), "reconnect=true");
  for (const char* element : {"edgesink", "edgesrc"}) {
    const std::string name = element;
    EXPECT_SAYS(start_error(name + " connect-type=CUSTOM"), "connect-type=CUSTOM is not available");
    EXPECT_SAYS(start_error(name + " connect-type=CUSTOM"), "fix: " + name + " connect-type=TCP");
    EXPECT_SAYS(start_error(name + " protocol=local connect-type=MQTT"), "has no broker");
  }
}

TEST_F(EdgeLocal, TwoEdgesinksDoNotShareAPath) {
  const auto out = sink();
  EXPECT_SAYS(start_error("edgesink" + ends_with()), "another process already listens on it");
}

TEST_F(EdgeLocal, PropertiesHaveNnstreamersValues) {
  const auto out = lone_element("edgesink");
  const auto in = lone_element("edgesrc");
  guint port = 1, dest = 1, own = 1;
  gboolean wait = TRUE;
  guint64 timeout = 1;
  gint type = 9;
  g_object_get(out.get(), "port", &port, "dest-port", &dest, "wait-connection", &wait,
               "connection-timeout", &timeout, "connect-type", &type, nullptr);
  g_object_get(in.get(), "port", &own, nullptr);
  EXPECT_EQ(port, 3000u);
  EXPECT_EQ(dest, 3000u);
  EXPECT_EQ(own, 0u);
  EXPECT_FALSE(wait);
  EXPECT_EQ(timeout, 0u);
  EXPECT_EQ(type, 0);
}

}  // namespace edgesink_test
