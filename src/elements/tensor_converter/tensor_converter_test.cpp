// tensor_converter in a harness: every video format, strides, chunks, bytes, errors.
#include <gst/check/gstharness.h>
#include <gst/video/video.h>
#include <gtest/gtest.h>

#include <numeric>
#include <string>
#include <vector>

#include "gstcpp/ref.hpp"

namespace {

using weir::gst::Mapped;
using weir::gst::Ref;
using weir::gst::Unique;
using Harness = Unique<GstHarness, gst_harness_teardown>;
using Bytes = std::vector<uint8_t>;

Harness harness(const std::string& properties, const std::string& caps) {
  Harness h{gst_harness_new_parse(("tensor_converter " + properties).c_str())};
  gst_harness_set_src_caps_str(h.get(), caps.c_str());
  return h;
}
std::string video(const std::string& format, int width, int height) {
  return "video/x-raw,format=" + format + ",width=" + std::to_string(width) +
         ",height=" + std::to_string(height) + ",framerate=10/1,interlace-mode=progressive";
}
Bytes ramp(size_t size) {
  Bytes out(size);
  std::iota(out.begin(), out.end(), uint8_t{0});
  return out;
}
GstBuffer* frame(const Bytes& bytes) {
  GstBuffer* b = gst_buffer_new_allocate(nullptr, bytes.size(), nullptr);
  gst_buffer_fill(b, 0, bytes.data(), bytes.size());
  return b;
}
Bytes content(GstBuffer* b) {
  const Mapped map(b, GST_MAP_READ);
  const auto span = map.as<const uint8_t>();
  return {span.begin(), span.end()};
}
std::string caps_text(const Harness& h) {
  auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(h->sinkpad));
  const weir::gst::UniqueText text{gst_caps_to_string(caps.get())};
  return text.get();
}
uint64_t stat(const Harness& h, const char* name) {
  const auto e = Ref<GstElement>::adopt(gst_harness_find_element(h.get(), "tensor_converter"));
  GstStructure* raw = nullptr;
  g_object_get(e.get(), "stats", &raw, nullptr);
  const Unique<GstStructure, gst_structure_free> stats(raw);
  guint64 value = UINT64_MAX;
  gst_structure_get_uint64(stats.get(), name, &value);
  return value;
}

class VideoFormat : public testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(VideoFormat, BecomesATensorWithoutACopy) {
  const auto [format, tensor] = GetParam();
  auto h = harness("", video(format, 8, 2));
  GstVideoInfo info;
  gst_video_info_set_format(&info, gst_video_format_from_string(format), 8, 2);
  const Bytes in = ramp(info.size);
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(in)));
  ASSERT_TRUE(out);
  EXPECT_NE(caps_text(h).find(tensor), std::string::npos) << caps_text(h);
  EXPECT_NE(caps_text(h).find("other/tensors"), std::string::npos);
  if (std::string(format) != "RGBP" && std::string(format) != "BGRP") {
    EXPECT_EQ(content(out.get()), in);
    EXPECT_EQ(stat(h, "bytes-copied"), 0u);
  }
}
INSTANTIATE_TEST_SUITE_P(All, VideoFormat,
                         testing::Values(std::pair{"RGB", "3:8:2:1"}, std::pair{"BGR", "3:8:2:1"},
                                         std::pair{"RGBx", "4:8:2:1"}, std::pair{"BGRx", "4:8:2:1"},
                                         std::pair{"xRGB", "4:8:2:1"}, std::pair{"xBGR", "4:8:2:1"},
                                         std::pair{"RGBA", "4:8:2:1"}, std::pair{"BGRA", "4:8:2:1"},
                                         std::pair{"ARGB", "4:8:2:1"}, std::pair{"ABGR", "4:8:2:1"},
                                         std::pair{"GRAY8", "1:8:2:1"},
                                         std::pair{"GRAY16_LE", "types=(string)uint16"},
                                         std::pair{"GRAY16_BE", "1:8:2:1"},
                                         std::pair{"RGBP", "8:2:3:1"},
                                         std::pair{"BGRP", "8:2:3:1"}));

TEST(TensorConverter, TakesThePaddingOfRowsAway) {
  auto h = harness("", video("RGB", 5, 2));  // 15 bytes a row, 16 with padding
  const Bytes in = ramp(32);
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(in)));
  Bytes expected(in.begin(), in.begin() + 15);
  expected.insert(expected.end(), in.begin() + 16, in.begin() + 31);
  EXPECT_EQ(content(out.get()), expected);
  EXPECT_EQ(stat(h, "bytes-copied"), 30u);
}

TEST(TensorConverter, HonoursStridesAndOffsetsOfTheBuffer) {
  auto h = harness("", video("GRAY8", 4, 2));
  const Bytes in = ramp(40);
  GstBuffer* b = frame(in);
  gsize offset[] = {3};
  gint stride[] = {20};
  gst_buffer_add_video_meta_full(b, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_GRAY8, 4, 2, 1,
                                 offset, stride);
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), b));
  EXPECT_EQ(content(out.get()), (Bytes{3, 4, 5, 6, 23, 24, 25, 26}));
}

// Rows from the last to the first, as pictures that stand on their head; and such that lead out.
TEST(TensorConverter, ReadsRowsBackwards) {
  auto h = harness("", video("GRAY8", 4, 2));
  GstBuffer* in = frame({4, 5, 6, 7, 0, 1, 2, 3});
  gsize offset[] = {4};
  gint stride[] = {-4};
  gst_buffer_add_video_meta_full(in, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_GRAY8, 4, 2, 1,
                                 offset, stride);
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  EXPECT_EQ(content(out.get()), (Bytes{0, 1, 2, 3, 4, 5, 6, 7}));
}

TEST(TensorConverter, RefusesOffsetsAndStridesThatLeadOutOfTheBuffer) {
  for (const auto& [first, step] : std::vector<std::pair<gsize, gint>>{
           {0, -4}, {8, 4}, {0, 8}, {G_MAXSIZE, 4}, {0, G_MAXINT}}) {
    auto h = harness("", video("GRAY8", 4, 2));
    GstBuffer* in = frame(ramp(8));
    gsize offset[] = {first};
    gint stride[] = {step};
    gst_buffer_add_video_meta_full(in, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_GRAY8, 4, 2, 1,
                                   offset, stride);
    EXPECT_EQ(gst_harness_push(h.get(), in), GST_FLOW_ERROR) << first << " " << step;
  }
}

TEST(TensorConverter, GathersFramesWithExactTime) {
  auto h = harness("frames-per-tensor=3", video("GRAY8", 4, 1));
  for (int i = 0; i < 7; ++i) {
    GstBuffer* b = frame(Bytes(4, static_cast<uint8_t>(i)));
    GST_BUFFER_PTS(b) = static_cast<guint64>(i) * 100 * GST_MSECOND;
    GST_BUFFER_DURATION(b) = 100 * GST_MSECOND;
    ASSERT_EQ(gst_harness_push(h.get(), b), GST_FLOW_OK);
  }
  for (int i = 0; i < 2; ++i) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(gst_buffer_get_size(out.get()), 12u);
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), static_cast<guint64>(i) * 300 * GST_MSECOND);
    EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 300 * GST_MSECOND);
  }
  EXPECT_EQ(gst_harness_buffers_in_queue(h.get()), 0u);
}

TEST(TensorConverter, FillsInMissingTimes) {
  auto h = harness("", video("GRAY8", 4, 1));
  for (int i = 0; i < 3; ++i) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(Bytes(4))));
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), static_cast<guint64>(i) * 100 * GST_MSECOND);
    EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 100 * GST_MSECOND);
  }
}

TEST(TensorConverter, LeavesTimesAloneWhenTold) {
  auto h = harness("set-timestamp=false", video("GRAY8", 4, 1));
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(Bytes(4))));
  EXPECT_FALSE(GST_BUFFER_PTS_IS_VALID(out.get()));
}

TEST(TensorConverter, CutsBytesIntoTensorsWithoutACopy) {
  auto h = harness("input-dim=2:1,3:1 input-type=uint8,uint16",
                   "application/octet-stream,framerate=10/1");
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(ramp(8))));
  ASSERT_EQ(gst_buffer_n_memory(out.get()), 2u);
  EXPECT_EQ(gst_memory_get_sizes(gst_buffer_peek_memory(out.get(), 1), nullptr, nullptr), 6u);
  EXPECT_EQ(content(out.get()), ramp(8));
  EXPECT_EQ(stat(h, "bytes-copied"), 0u);
}

TEST(TensorConverter, SplitsABufferOfSeveralFrames) {
  auto h = harness("input-dim=4 input-type=uint8", "application/octet-stream,framerate=10/1");
  ASSERT_EQ(gst_harness_push(h.get(), frame(ramp(12))), GST_FLOW_OK);
  EXPECT_EQ(gst_harness_buffers_in_queue(h.get()), 3u);
  for (uint8_t i = 0; i < 3; ++i) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(content(out.get())[0], 4 * i);
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), i * 100 * GST_MSECOND);
  }
}

TEST(TensorConverter, RefusesBuffersThatAreNoWholeFrames) {
  auto bytes = harness("input-dim=4 input-type=uint8", "application/octet-stream,framerate=10/1");
  EXPECT_EQ(gst_harness_push(bytes.get(), frame(ramp(7))), GST_FLOW_ERROR);
  auto picture = harness("", video("RGB", 8, 2));
  EXPECT_EQ(gst_harness_push(picture.get(), frame(ramp(20))), GST_FLOW_ERROR);
  EXPECT_EQ(stat(picture, "dropped-error"), 1u);
  auto empty = harness("", video("RGB", 8, 2));
  EXPECT_EQ(gst_harness_push(empty.get(), gst_buffer_new()), GST_FLOW_ERROR);
}

std::string caps_error(const std::string& properties, const std::string& text) {
  auto element = Ref<GstElement>::adopt(GST_ELEMENT(
      gst_object_ref_sink(gst_parse_launch(("tensor_converter " + properties).c_str(), nullptr))));
  auto bus = Ref<GstBus>::adopt(gst_bus_new());
  gst_element_set_bus(element.get(), bus.get());
  gst_element_set_state(element.get(), GST_STATE_PAUSED);
  auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), "sink"));
  gst_pad_send_event(pad.get(), gst_event_new_stream_start("test"));
  auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(text.c_str()));
  EXPECT_FALSE(gst_pad_send_event(pad.get(), gst_event_new_caps(caps.get())));
  auto message = Ref<GstMessage>::adopt(gst_bus_pop_filtered(bus.get(), GST_MESSAGE_ERROR));
  gst_element_set_state(element.get(), GST_STATE_NULL);
  gst_element_set_bus(element.get(), nullptr);
  if (!message) return "";
  GError* error = nullptr;
  gst_message_parse_error(message.get(), &error, nullptr);
  const std::string out = error->message;
  g_error_free(error);
  return out;
}

TEST(TensorConverter, SaysWhatABytesStreamNeeds) {
  const auto text = caps_error("", "application/octet-stream");
  EXPECT_NE(text.find("tensor_converter input-dim=3:224:224:1 input-type=uint8"), std::string::npos)
      << text;
}

TEST(TensorConverter, NamesTheDifferenceToWhatTheUserSaid) {
  const auto text = caps_error("input-dim=3:9:2:1 input-type=uint8", video("RGB", 8, 2));
  EXPECT_NE(text.find("WEIR-2001"), std::string::npos) << text;
  EXPECT_NE(text.find("3:8:2:1, needed is 3:9:2:1"), std::string::npos) << text;
}

TEST(TensorConverter, RefusesPropertiesWithATypo) {
  EXPECT_NE(
      caps_error("input-dim=x input-type=uint8", "application/octet-stream").find("WEIR-1002"),
      std::string::npos);
  EXPECT_NE(
      caps_error("input-dim=3 input-type=uint9", "application/octet-stream").find("WEIR-1003"),
      std::string::npos);
  EXPECT_NE(
      caps_error("input-dim=3,4 input-type=uint8", "application/octet-stream").find("WEIR-1004"),
      std::string::npos);
}

}  // namespace
