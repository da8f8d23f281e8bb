// tensor_converter in a harness: every video format, strides, chunks, bytes, errors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/video/video.h>

#include "core/tensor/tensor_header.hpp"
#include "elements/tensor_converter/converter_test_support.hpp"

namespace tensor_converter_test {

using namespace weir;
using namespace weir::testing_tensor_converter;

class VideoFormat : public testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(VideoFormat, BecomesATensorWithoutACopy) {
  const auto [format, tensor] = GetParam();
  auto h = harness("", video(format, 8, 2));
  GstVideoInfo info;
  gst_video_info_set_format(&info, gst_video_format_from_string(format), 8, 2);
  const Bytes in = ramp(info.size);
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(in)));
  ASSERT_TRUE(out);
  EXPECT_SAYS(caps_text(h), tensor);
  EXPECT_SAYS(caps_text(h), "other/tensors");
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
  auto h = harness("", video("RGB", 5, 2));  // rows of 15 bytes, 16 with padding
  const Bytes in = ramp(32);
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(in)));
  Bytes expected(in.begin(), in.begin() + 15);
  expected.insert(expected.end(), in.begin() + 16, in.begin() + 31);
  EXPECT_EQ(content(out.get()), expected);
  EXPECT_EQ(stat(h, "bytes-copied"), 30u);
}

// docs/compatibility/converter.md 2.3: the dimensions decide, with or without a type.
TEST(TensorConverter, OffersTheSizeThatDownstreamPrefersFirst) {
  const std::string any =
      "video/x-raw,format={GRAY8,RGB,BGRx,RGBP},width=[1,999],height=[1,999],framerate=[0/1,60/"
      "1],interlace-mode=progressive";
  const std::pair<const char*, const char*> cases[] = {
      {"1:16:12:1", "GRAY8"}, {"3:16:12", "RGB"}, {"4:16:12:1:1", "BGRx"}, {"16:12:3:1", "RGBP"}};
  for (const auto& [dimension, format] : cases)
    for (const char* more : {"", ",type=uint8"}) {
      const auto h = make_harness("tensor_converter");
      gst_harness_set_sink_caps_str(h.get(), ("other/tensor,dimension=(string)" +
                                              std::string(dimension) + more + ",framerate=7/1")
                                                 .c_str());
      const std::string message = accepted(h, any);
      EXPECT_SAYS(message.substr(0, message.find(';')),
                  std::string("format=(string)") + format + ",")
          << dimension << more;
      EXPECT_SAYS(message.substr(0, message.find(';')),
                  "width=(int)16, height=(int)12, framerate=(fraction)7/1")
          << dimension << more;
    }
}

TEST(TensorConverter, OffersOnlyWhatDownstreamAcceptsUnlessNothingFits) {
  const auto h = make_harness("tensor_converter");
  gst_harness_set_sink_caps_str(h.get(), "other/tensor,dimension=(string)3:16:12:1,type=uint8");
  const std::string any = accepted(
      h, "video/x-raw,format={BGR,RGBA,GRAY8,RGB},width=[1,999],height=[1,999],framerate=5/1");
  EXPECT_LT(any.find("format=(string)RGB"), any.find("format=(string)BGR"));
  EXPECT_LACKS(any, "RGBA");
  EXPECT_LACKS(any, "GRAY8");
  EXPECT_LACKS(any, "999");
  EXPECT_SAYS(accepted(h, "video/x-raw,format=RGBA,width=64,height=48,framerate=5/1"), "RGBA");
  EXPECT_SAYS(accepted(h, "application/octet-stream"), "application/octet-stream");
}

// So that no caps need to be written between a camera and a model.
TEST(TensorConverter, ConvertersBeforeItMakeRgbOfTheSizeThatDownstreamNeeds) {
  for (const char* format : {"RGBA", "BGRx", "GRAY8", "I420", "RGB"}) {
    const auto h = make_harness(
        "videoconvert ! videoscale ! tensor_converter name=c ! capsfilter "
        "caps=\"other/tensor,dimension=(string)3:16:12:1,type=uint8\"");
    gst_harness_set_src_caps_str(h.get(), video(format, 64, 48).c_str());
    const auto converter = find_element(h, "tensor_converter");
    const auto sink = Ref<GstPad>::adopt(gst_element_get_static_pad(converter.get(), "sink"));
    const auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(sink.get()));
    ASSERT_TRUE(caps) << format;
    const gst::UniqueText text(gst_caps_to_string(caps.get()));
    EXPECT_SAYS(text.get(), "width=(int)16, height=(int)12") << format;
    EXPECT_SAYS(text.get(), "format=(string)RGB") << format;
  }
}

// A query walks the rest of the pipeline.
TEST(TensorConverter, AsksDownstreamForItsCapsOnce) {
  const auto h = make_harness("tensor_converter");
  gst_harness_set_sink_caps_str(h.get(), "other/tensors");
  const auto source = Ref<GstPad>::adopt(gst_element_get_static_pad(h->element, "src"));
  int queries = 0;
  const auto count = [](GstPad*, GstPadProbeInfo* info, gpointer queries) {
    if (GST_QUERY_TYPE(GST_PAD_PROBE_INFO_QUERY(info)) == GST_QUERY_CAPS)
      ++*static_cast<int*>(queries);
    return GST_PAD_PROBE_OK;
  };
  gst_pad_add_probe(source.get(),
                    GstPadProbeType(GST_PAD_PROBE_TYPE_QUERY_DOWNSTREAM | GST_PAD_PROBE_TYPE_PUSH),
                    count, &queries, nullptr);
  gst_harness_set_src_caps_str(h.get(), video("RGB", 4, 2).c_str());
  EXPECT_SAYS(caps_text(h), "3:4:2:1");
  EXPECT_EQ(queries, 1);
}

TEST(TensorConverter, OffersEverySizeIfDownstreamHasNoPreference) {
  const std::string any =
      "video/x-raw,format=RGB,width=[1,999],height=[1,999],framerate=[0/1,60/"
      "1],interlace-mode=progressive";
  for (const char* caps : {"other/tensor,type=uint8", "other/tensor,dimension=(string)3",
                           "other/tensors,format=flexible"}) {
    const auto h = make_harness("tensor_converter");
    gst_harness_set_sink_caps_str(h.get(), caps);
    EXPECT_SAYS(accepted(h, any), "width=(int)[ 1, 999 ], height=(int)[ 1, 999 ]") << caps;
  }
}

// A transform that changes the type fixes only the dimensions.
TEST(TensorConverter, OffersTheSizeThatAnElementDownstreamOfATransformPrefers) {
  const auto h = make_harness(
      "tensor_converter ! tensor_transform mode=typecast option=float32 ! capsfilter "
      "caps=\"other/tensor,dimension=(string)3:16:12:1,type=float32\"");
  EXPECT_SAYS(accepted(h, "video/x-raw,format=RGB,width=[1,999],height=[1,999]"),
              "width=(int)16, height=(int)12");
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

// Bottom-up rows, as in flipped pictures, and strides that leave the buffer.
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

TEST(TensorConverter, KeepsTimesIfConfigured) {
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

TEST(TensorConverter, MakesEachBufferOneFlexibleTensorOfItsOwnSize) {
  Harness h{gst_harness_new_parse("tensor_converter")};
  gst_harness_set_sink_caps_str(h.get(), "other/tensors,format=flexible");
  gst_harness_set_src_caps_str(h.get(), "application/octet-stream,framerate=10/1");
  for (const uint8_t size : {5, 9}) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(ramp(size))));
    const Bytes all = content(out.get());
    const auto header = read_tensor_header(std::as_bytes(std::span(all)));
    ASSERT_TRUE(header);
    EXPECT_EQ(header->spec.to_string(), "uint8 " + std::to_string(size));
    EXPECT_EQ(header->media, MediaType::Octet);
    EXPECT_EQ(Bytes(all.begin() + kTensorHeaderBytes, all.end()), ramp(size));
  }
  EXPECT_EQ(gst_harness_buffers_in_queue(h.get()), 0u);
}

TEST(TensorConverter, RefusesSeveralFramesInOneVideoBuffer) {
  auto h = harness("", video("RGB", 8, 2));
  const auto text = get_error(h, frame(ramp(96)));
  EXPECT_SAYS(text, "WEIR-2004: a video buffer holds more than one frame");
  EXPECT_SAYS(text, "fix: put rawvideoparse downstream of the source");
  auto longer = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(ramp(95))));
  EXPECT_EQ(content(longer.get()), ramp(48)) << "bytes after one frame are padding";
}

TEST(TensorConverter, GathersNoBytesForFlexibleTensors) {
  Harness h{
      gst_harness_new_parse("tensor_converter input-dim=4 input-type=uint8 frames-per-tensor=2")};
  Errors errors(h);
  gst_harness_set_sink_caps_str(h.get(), "other/tensors,format=flexible");
  gst_harness_set_src_caps_str(h.get(), "application/octet-stream,framerate=10/1");
  EXPECT_SAYS(errors.next(),
              "WEIR-1004: bytes for flexible tensors cannot be combined into one output");
}

TEST(TensorConverter, GathersNeitherBuffersOfAnySizeNorSeveralTensors) {
  const auto several = caps_error("frames-per-tensor=2 input-dim=2,3 input-type=uint8,uint8",
                                  "application/octet-stream");
  EXPECT_SAYS(several, "WEIR-1004: several tensors cannot be combined into one output");
  EXPECT_SAYS(several, "fix: tensor_converter frames-per-tensor=1");
  const auto huge =
      caps_error("frames-per-tensor=4294967295 input-dim=4294967295:2147483647 input-type=uint8",
                 "application/octet-stream");
  EXPECT_SAYS(huge, "WEIR-2006: the tensors are too big");
}

TEST(TensorConverter, TakesOtherCapsInTheMiddleOfAStream) {
  auto h = harness("", video("RGB", 8, 2));
  gst_buffer_unref(gst_harness_push_and_pull(h.get(), frame(ramp(48))));
  EXPECT_EQ(change_caps(h, video("GRAY8", 4, 3)), "");
  gst_buffer_unref(gst_harness_push_and_pull(h.get(), frame(ramp(12))));
  EXPECT_SAYS(caps_text(h), "1:4:3:1");
  EXPECT_SAYS(change_caps(h, "application/octet-stream"), "the tensors in the byte stream");
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

TEST(TensorConverter, NamesWhatAByteStreamNeeds) {
  const auto text = caps_error("", "application/octet-stream");
  EXPECT_SAYS(text, "tensor_converter input-dim=3:224:224:1 input-type=uint8");
}

TEST(TensorConverter, NamesTheDifferenceToTheProperties) {
  const auto text = caps_error("input-dim=3:9:2:1 input-type=uint8", video("RGB", 8, 2));
  EXPECT_SAYS(text, "WEIR-2001");
  EXPECT_SAYS(text, "3:8:2:1, needed is 3:9:2:1");
}

TEST(TensorConverter, RefusesPropertiesWithATypo) {
  EXPECT_SAYS(start_error("tensor_converter input-dim=x input-type=uint8"), "WEIR-1002");
  EXPECT_SAYS(start_error("tensor_converter input-dim=3 input-type=uint9"), "WEIR-1003");
  EXPECT_SAYS(start_error("tensor_converter input-dim=3,4 input-type=uint8"), "WEIR-1004");
  EXPECT_SAYS(start_error("tensor_converter mode=custom:x"), "WEIR-1005");
  EXPECT_EQ(start_error("tensor_converter"), "");
}

}  // namespace tensor_converter_test
