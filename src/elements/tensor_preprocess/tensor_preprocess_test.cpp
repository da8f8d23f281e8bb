// tensor_preprocess in a harness: values, caps, metadata of buffers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_preprocess/preprocess_test_support.hpp"
#include "elements/tests/second_thread_test_support.hpp"

namespace weir::preprocess_test {
namespace tensor_preprocess_test {

TEST(TensorPreprocess, PassesPixelsOfTheSameSize) {
  auto h = harness("width=4 height=2", video("RGB", 4, 2));
  EXPECT_EQ(pushed<uint8_t>(h, frame(ramp(24))), ramp(24));
  EXPECT_SAYS(caps_text(h), "types=(string)uint8");
  EXPECT_SAYS(caps_text(h), "3:4:2:1");
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)10/1");
}

TEST(TensorPreprocess, NormalisesEachChannelAndTransposes) {
  auto h = harness("width=4 height=1 mean=0,1,2 scale=1,2,4 layout=NCHW", video("BGR", 4, 1));
  const auto out = pushed<float>(h, frame(ramp(12)));
  ASSERT_EQ(out.size(), 12u);
  for (size_t x = 0; x < 4; ++x) {
    EXPECT_EQ(out[x], static_cast<float>(3 * x + 2));
    EXPECT_EQ(out[4 + x], (static_cast<float>(3 * x + 1) - 1) * 2);
    EXPECT_EQ(out[8 + x], (static_cast<float>(3 * x) - 2) * 4);
  }
  EXPECT_SAYS(caps_text(h), "float32");
}

TEST(TensorPreprocess, ConvertsLimitedAndFullRange) {
  // Y = 81, Cb = 90, Cr = 240 is red of BT.601 limited: 255 * 65 / 219 + ... computed by hand.
  const Bytes red{81, 81, 0, 0, 81, 81, 0, 0, 90, 240, 0, 0};  // rows are of four bytes
  auto h = harness("width=2 height=2", video("NV12", 2, 2, ",colorimetry=bt601"));
  const auto out = pushed<uint8_t>(h, frame(red));
  ASSERT_EQ(out.size(), 12u);
  EXPECT_EQ(out[0], 254);  // 75.68 + 1.402 * 127.5 = 254.4
  EXPECT_EQ(out[1], 0);    // 75.68 + 0.344 * 43.26 - 0.714 * 127.5 = -0.5
  EXPECT_EQ(out[2], 0);    // 75.68 - 1.772 * 43.26 = -1.0
  // Full range and BT.709: 81 + 1.5748 * 112 = 257.4; 81 + 0.1873 * 38 - 0.4681 * 112 = 35.7;
  // 81 - 1.8556 * 38 = 10.5 (10.487).
  auto full = harness("width=2 height=2", video("NV12", 2, 2, ",colorimetry=1:3:5:1"));
  const auto other = pushed<uint8_t>(full, frame(red));
  ASSERT_EQ(other.size(), 12u);
  EXPECT_EQ(other[0], 255);
  EXPECT_EQ(other[1], 36);
  EXPECT_EQ(other[2], 10);
}

TEST(TensorPreprocess, TakesSizeTypeAndLayoutFromDownstream) {
  Harness h{gst_harness_new("tensor_preprocess")};
  gst_harness_set_sink_caps_str(h.get(),
                                "other/tensors,format=static,num_tensors=1,"
                                "dimensions=(string)4:3:3:1,types=(string)float16,framerate=10/1");
  gst_harness_set_src_caps_str(h.get(), video("I420", 20, 10).c_str());
  GstVideoInfo info;
  gst_video_info_set_format(&info, GST_VIDEO_FORMAT_I420, 20, 10);
  EXPECT_EQ(pushed<uint16_t>(h, frame(Bytes(info.size, 128))).size(), 36u);
}

TEST(TensorPreprocess, QueriesFollowTheSizeThatWasSetLast) {
  const auto element = lone_element("tensor_preprocess width=4 height=4");
  const auto source = Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), "src"));
  const auto offered = [&] {
    const auto caps = Ref<GstCaps>::adopt(gst_pad_query_caps(source.get(), nullptr));
    return std::string(gst::UniqueText(gst_caps_to_string(caps.get())).get());
  };
  SecondThread reader([&] { offered(); });
  for (int round = 0; round < 200; ++round)
    for (const guint width : {5u, 6u}) {
      g_object_set(element.get(), "width", width, nullptr);
      ASSERT_NE(offered().find("3:" + std::to_string(width) + ":4"), std::string::npos) << round;
    }
}

TEST(TensorPreprocess, AcceptsTheOldSpellingOfOneTensor) {
  Harness h{gst_harness_new_parse("tensor_preprocess width=4 height=3")};
  gst_harness_set_sink_caps_str(h.get(),
                                "other/tensor,framerate=10/1,type=(string)uint8,"
                                "dimension=(string)3:4:3:1");
  gst_harness_set_src_caps_str(h.get(), video("RGB", 4, 3).c_str());
  EXPECT_EQ(pushed<uint8_t>(h, frame(ramp(36))), ramp(36));
}

TEST(TensorPreprocess, LetterboxesWithThePaddingValue) {
  auto h = harness("width=4 height=4 fit=letterbox padding-value=114", video("RGB", 4, 2));
  const auto out = pushed<uint8_t>(h, frame(ramp(24)));
  ASSERT_EQ(out.size(), 48u);
  for (size_t i = 0; i < 48; ++i) EXPECT_EQ(out[i], i < 12 || i >= 36 ? 114 : i - 12);
}

TEST(TensorPreprocess, FollowsNewCapsAndKeepsTime) {
  auto h = harness("width=2 height=1", "video/x-raw,format=RGB,width=2,height=1,framerate=10/1");
  EXPECT_EQ(pushed<uint8_t>(h, frame(ramp(8))), ramp(6));  // rows are of eight bytes
  gst_harness_set_src_caps_str(h.get(), video("BGRx", 2, 1).c_str());
  GstBuffer* in = frame(ramp(8));
  GST_BUFFER_PTS(in) = 7 * GST_SECOND;
  GST_BUFFER_DURATION(in) = GST_SECOND;
  ASSERT_EQ(gst_harness_push(h.get(), in), GST_FLOW_OK);
  const auto out = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
  ASSERT_TRUE(out);
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), 7 * GST_SECOND);
  EXPECT_EQ(GST_BUFFER_DURATION(out.get()), GST_SECOND);
  EXPECT_FALSE(gst_buffer_get_video_meta(out.get()));
  const Mapped map(out.get(), GST_MAP_READ);
  EXPECT_EQ(Bytes(map.as<const uint8_t>().begin(), map.as<const uint8_t>().end()),
            (Bytes{2, 1, 0, 6, 5, 4}));
  EXPECT_EQ(stat(h, "received"), 2u);
  EXPECT_EQ(stat(h, "consumed"), 2u);
  EXPECT_EQ(stat(h, "pushed"), 2u);
  EXPECT_EQ(stat(h, "pool-allocated"), 1u);  // the new caps' pool, in use
}

TEST(TensorPreprocess, HonoursStridesAndOffsets) {
  auto h = harness("width=3 height=2 channel-order=GRAY", video("GRAY8", 3, 2));
  GstBuffer* in = frame({9, 9, 1, 2, 3, 9, 4, 5, 6});
  gsize offsets[GST_VIDEO_MAX_PLANES] = {2, 0, 0, 0};
  gint strides[GST_VIDEO_MAX_PLANES] = {4, 0, 0, 0};
  gst_buffer_add_video_meta_full(in, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_GRAY8, 3, 2, 1,
                                 offsets, strides);
  EXPECT_EQ(pushed<uint8_t>(h, in), (Bytes{1, 2, 3, 4, 5, 6}));
}

TEST(TensorPreprocess, ReadsPlanesInSeparateMemories) {
  auto h =
      harness("width=2 height=2 channel-order=GRAY", video("NV12", 2, 2, ",colorimetry=1:4:5:1"));
  GstBuffer* in = frame({10, 20, 30, 40});
  gst_buffer_append(in, frame({128, 128}));
  gsize offsets[GST_VIDEO_MAX_PLANES] = {0, 4, 0, 0};
  gint strides[GST_VIDEO_MAX_PLANES] = {2, 2, 0, 0};
  gst_buffer_add_video_meta_full(in, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_NV12, 2, 2, 2,
                                 offsets, strides);
  EXPECT_EQ(pushed<uint8_t>(h, in), (Bytes{10, 20, 30, 40}));
}

TEST(TensorPreprocess, GivesTheSameResultWithSeveralThreads) {
  std::vector<float> wanted;
  for (const char* threads : {"1", "2", "3"}) {
    auto h = harness(std::string("width=33 height=21 fit=letterbox mean=3 threads=") + threads,
                     video("GRAY8", 40, 30));
    const auto out = pushed<float>(h, frame(ramp(1200)));
    ASSERT_EQ(out.size(), 33u * 21 * 3);
    if (wanted.empty()) wanted = out;
    EXPECT_EQ(out, wanted);
  }
}

TEST(TensorPreprocess, HonoursTheCropOfEachBuffer) {
  auto h = harness("width=2 height=1 channel-order=GRAY", video("GRAY8", 4, 3));
  GstBuffer* in = frame(ramp(12));
  crop(in, 1, 2, 2, 1);
  EXPECT_EQ(pushed<uint8_t>(h, in), (Bytes{9, 10}));
  in = frame(ramp(12));
  crop(in, 0, 0, 2, 1);
  EXPECT_EQ(pushed<uint8_t>(h, in), (Bytes{0, 1}));
  EXPECT_EQ(pushed<uint8_t>(h, frame(ramp(12))).size(), 2u);
}

}  // namespace tensor_preprocess_test
}  // namespace weir::preprocess_test
