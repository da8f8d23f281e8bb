// tensor_decoder in a stream: invalid decoder output, metadata, flushes, EOS, the ledger. The
// decoder `erring` is tests/support/erring/erring_decoder.cpp.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/video/video.h>

#include "elements/tensor_decoder/decoder_test_support.hpp"

namespace weir::testing_tensor_decoder {
namespace stream_test {

const std::string kOne = tensor("uint8", "1");

std::string erring(const std::string& where, const std::string& what) {
  return "mode=erring option1=" + where + " option2=" + what;
}
void expect_contract(const Harness& h, uint64_t received, uint64_t pushed) {
  EXPECT_EQ(stat(h, "received"), received);
  EXPECT_EQ(stat(h, "pushed"), pushed);
  EXPECT_EQ(stat(h, "consumed"), pushed);
  EXPECT_EQ(stat(h, "held"), 0u);
}

TEST(TensorDecoderStream, TurnsWhatADecoderThrowsIntoErrors) {
  for (const char* where : {"open", "configure", "decode"}) {
    const auto message = [&](const char* what) {
      return get_error(erring(where, what), kOne, {1});
    };
    const std::string failure = message("failure");
    EXPECT_SAYS(failure, "WEIR-1004: failed as ordered");
    EXPECT_SAYS(failure, "first difference: the first difference");
    EXPECT_SAYS(failure, "needed: another option2");
    EXPECT_SAYS(failure, "fix: option2=nothing");
    EXPECT_SAYS(message("exception"),
                "WEIR-5003: a class in C++ threw an exception\n  offered: thrown in a decoder");
    EXPECT_SAYS(message("memory"), "WEIR-9001: memory ran out in a module");
    EXPECT_SAYS(message("number"), "offered: not derived from std::exception");
  }
}

TEST(TensorDecoderStream, NeedsCapsOfTheDecoder) {
  for (const char* where : {"no-caps", "bad-caps"}) {
    const std::string message = get_error(erring(where, "nothing"), kOne, {1});
    EXPECT_SAYS(message, "WEIR-5003: the decoder returned invalid caps");
    EXPECT_SAYS(message, "for example text/x-raw,format=(string)utf8");
  }
}

// GstBaseTransform alone posts no error for this.
TEST(TensorDecoderStream, NamesWhatDownstreamDoesNotAccept) {
  const Harness h{gst_harness_new_parse("tensor_decoder mode=direct_video")};
  Errors errors(h);
  gst_harness_set_sink_caps_str(h.get(), "video/x-raw,format=RGB,width=9,height=[1,100]");
  gst_harness_set_src_caps_str(h.get(), tensor("uint8", "3:8:4").c_str());
  const std::string error = errors.next();
  EXPECT_SAYS(error,
              "WEIR-2001: the element downstream of tensor_decoder does not accept its output");
  EXPECT_SAYS(error, "width=(int)8");
  EXPECT_SAYS(error, "needed: video/x-raw, format=(string)RGB, width=(int)9");
  EXPECT_SAYS(error, "fix: tensor_decoder ! videoconvert ! videoscale");
  EXPECT_EQ(errors.next(), "") << "reported once";
}

TEST(TensorDecoderStream, GivesNoMemoryBeforeThereIsAFrame) {
  EXPECT_SAYS(get_error(erring("early-memory", "nothing"), kOne, {1}), "WEIR-9001");
}

TEST(TensorDecoderStream, SharesNoTensorThatIsNotThere) {
  EXPECT_SAYS(get_error(erring("no-such-input", "nothing"), kOne, {1}),
              "the host cannot share an input\n  offered: 7");
}

TEST(TensorDecoderStream, CountsTheFramesThatADecoderDrops) {
  auto h = harness("mode=erring option1=drop-odd", kOne);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{1})), GST_FLOW_OK);
  EXPECT_EQ(gst_harness_buffers_in_queue(h.get()), 3u);
  EXPECT_EQ(stat(h, "dropped-policy"), 2u);
  expect_contract(h, 5, 3);
}

TEST(TensorDecoderStream, CountsTheFramesThatFail) {
  auto h = harness("mode=erring option1=decode option2=failure", kOne);
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{1})), GST_FLOW_ERROR);
  EXPECT_EQ(stat(h, "dropped-error"), 1u);
  expect_contract(h, 1, 0);
}

TEST(TensorDecoderStream, ResetsTheDecoderOnAFlush) {
  auto h = harness("mode=erring option1=count", kOne);
  EXPECT_EQ(decoded(h, frame(Bytes{9})), Bytes{1});
  EXPECT_EQ(decoded(h, frame(Bytes{9})), Bytes{2});
  gst_harness_push_event(h.get(), gst_event_new_flush_start());
  gst_harness_push_event(h.get(), gst_event_new_flush_stop(TRUE));
  gst_harness_push_event(h.get(), time_segment());
  EXPECT_EQ(decoded(h, frame(Bytes{9})), Bytes{1});
  expect_contract(h, 3, 3);
}

TEST(TensorDecoderStream, EndsWithItsInput) {
  auto h = harness("mode=octet_stream", tensor("uint8", "2"));
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{1, 2})), GST_FLOW_OK);
  EXPECT_TRUE(gst_harness_push_event(h.get(), gst_event_new_eos()));
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{3, 4})), GST_FLOW_EOS);
  bool ended = false;
  while (const auto event = Ref<GstEvent>::adopt(gst_harness_try_pull_event(h.get())))
    ended |= GST_EVENT_TYPE(event.get()) == GST_EVENT_EOS;
  EXPECT_TRUE(ended);
  expect_contract(h, 1, 1);
}

TEST(TensorDecoderStream, RefusesNewCapsThatDoNotFit) {
  auto h = harness("mode=direct_video", tensor("uint8", "3:4:2"));
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes(24))), GST_FLOW_OK);
  gst_harness_set_src_caps_str(h.get(), tensor("uint8", "2:4:2").c_str());
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes(16))), GST_FLOW_NOT_NEGOTIATED);
}

TEST(TensorDecoderStream, StartsAgain) {
  auto h = harness("mode=erring option1=count", kOne);
  EXPECT_EQ(decoded(h, frame(Bytes{9})), Bytes{1});
  EXPECT_EQ(decoded(h, frame(Bytes{9})), Bytes{2});
  const auto e = Ref<GstElement>::adopt(gst_harness_find_element(h.get(), "tensor_decoder"));
  gst_element_set_state(e.get(), GST_STATE_READY);
  gst_element_set_state(e.get(), GST_STATE_PLAYING);
  gst_harness_push_event(h.get(), gst_event_new_stream_start("again"));
  gst_harness_set_src_caps_str(h.get(), kOne.c_str());
  EXPECT_EQ(decoded(h, frame(Bytes{9})), Bytes{1});
  expect_contract(h, 1, 1);
}

// The strides of the camera's frame do not apply to the tensor: GStreamer drops that meta.
TEST(TensorDecoderStream, DropsStridesOfOtherMemory) {
  auto h = harness("mode=direct_video", tensor("uint8", "3:4:2"));
  GstBuffer* in = frame(Bytes(24));
  gsize offset[] = {0};
  gint stride[] = {64};
  gst_buffer_add_video_meta_full(in, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_RGB, 4, 2, 1,
                                 offset, stride);
  const auto clock = Ref<GstCaps>::adopt(gst_caps_new_empty_simple("timestamp/x-ntp"));
  gst_buffer_add_reference_timestamp_meta(in, clock.get(), 5, GST_CLOCK_TIME_NONE);
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  ASSERT_TRUE(out);
  EXPECT_EQ(gst_buffer_get_video_meta(out.get()), nullptr);
  const auto* kept = gst_buffer_get_reference_timestamp_meta(out.get(), clock.get());
  ASSERT_NE(kept, nullptr) << "what does not describe the memory stays";
  EXPECT_EQ(kept->timestamp, 5u);
}

TEST(TensorDecoderStream, MakesTheCamerasPictureAgainWhateverItsStrides) {
  const Harness h{gst_harness_new_parse("tensor_converter ! tensor_decoder mode=direct_video")};
  gst_harness_set_src_caps_str(h.get(),
                               "video/x-raw,format=RGB,width=4,height=2,framerate=30/1,"
                               "interlace-mode=progressive");
  Bytes camera(64 * 2, 0xEE);
  for (size_t i = 0; i < 12; ++i) camera[i] = camera[64 + i] = static_cast<uint8_t>(i);
  GstBuffer* in = frame(camera);
  gsize offset[] = {0};
  gint stride[] = {64};
  gst_buffer_add_video_meta_full(in, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_RGB, 4, 2, 1,
                                 offset, stride);
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  const auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(h->sinkpad));
  GstVideoInfo info;
  ASSERT_TRUE(gst_video_info_from_caps(&info, caps.get()));
  GstVideoFrame picture;
  ASSERT_TRUE(gst_video_frame_map(&picture, &info, out.get(), GST_MAP_READ));
  const auto* second = static_cast<const uint8_t*>(GST_VIDEO_FRAME_PLANE_DATA(&picture, 0)) +
                       GST_VIDEO_FRAME_PLANE_STRIDE(&picture, 0);
  EXPECT_EQ(GST_VIDEO_FRAME_PLANE_STRIDE(&picture, 0), 12);
  EXPECT_EQ(Bytes(second, second + 12), Bytes(camera.begin(), camera.begin() + 12));
  gst_video_frame_unmap(&picture);
}

}  // namespace stream_test
}  // namespace weir::testing_tensor_decoder
