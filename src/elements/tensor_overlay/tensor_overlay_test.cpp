// Which results are drawn on which picture, and into which memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>

#include "elements/tensor_overlay/overlay_test_support.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir::overlay_test {
namespace tensor_overlay_test {

constexpr GstClockTime kTenth = GST_SECOND / 10;

TEST(TensorOverlay, DrawsTheNewestResultsOnEachPicture) {
  const Both b("");
  EXPECT_EQ(b.picture(kSmall, 0), Bytes(kSmall));
  ASSERT_EQ(b.push({1, 1, 7, 6, 0.5f, 0}, kTenth), GST_FLOW_OK);
  for (int i = 1; i < 4; ++i) EXPECT_EQ(b.picture(kSmall, i * kTenth), small_with({{1, 1, 7, 6}}));
  b.push({0, 0, 3, 3, 0.5f, 2}, 3 * kTenth);
  b.push({0, 1, 6, 6, 0.5f, 1}, 4 * kTenth);
  EXPECT_EQ(b.picture(kSmall, 4 * kTenth), small_with({{0, 1, 6, 6, 1}}));
  EXPECT_EQ(b.stat("results-drawn"), 2u);
  EXPECT_EQ(b.stat("results-replaced"), 1u);
  EXPECT_EQ(b.stat("pictures-drawn"), 4u);
  EXPECT_EQ(b.stat("boxes-drawn"), 4u);
  EXPECT_EQ(b.stat("pushed"), 5u);
  b.expect_results_balance();
}

// As when a file is decoded faster than it is displayed.
TEST(TensorOverlay, KeepsResultsForLaterPictures) {
  const Both b("");
  b.push({1, 1, 7, 6, 0.5f, 0}, 0);
  b.push({0, 1, 6, 6, 0.5f, 1}, 2 * kTenth);
  b.push({0, 0, 3, 3, 0.5f, 2}, 3 * kTenth);
  EXPECT_EQ(b.picture(kSmall, 0), small_with({{1, 1, 7, 6}}));
  EXPECT_EQ(b.picture(kSmall, kTenth), small_with({{1, 1, 7, 6}}));
  EXPECT_EQ(b.picture(kSmall, 2 * kTenth), small_with({{0, 1, 6, 6, 1}}));
  EXPECT_EQ(b.stat("results-held"), 1u);
  EXPECT_EQ(b.picture(kSmall, 3 * kTenth), small_with({{0, 0, 3, 3, 2}}));
  EXPECT_EQ(b.stat("results-drawn"), 3u);
  b.expect_results_balance();
}

TEST(TensorOverlay, SkipsResultsBeyondMaxAge) {
  const Both b("max-age=100000000");
  const Bytes drawn = small_with({{1, 1, 7, 6}});
  b.push({1, 1, 7, 6, 1, 0}, 5 * kTenth);
  EXPECT_EQ(b.picture(kSmall, 3 * kTenth), Bytes(kSmall));
  EXPECT_EQ(b.picture(kSmall, 4 * kTenth), drawn);
  EXPECT_EQ(b.picture(kSmall, 6 * kTenth), drawn);
  EXPECT_EQ(b.picture(kSmall, 6 * kTenth + 1), Bytes(kSmall));
  EXPECT_EQ(b.picture(kSmall, GST_CLOCK_TIME_NONE), drawn);
  g_object_set(b.element.get(), "max-age", guint64{0}, nullptr);
  EXPECT_EQ(b.picture(kSmall, 3600 * GST_SECOND), drawn);
  b.push({0, 0, 8, 6, 1, 0}, GST_CLOCK_TIME_NONE);
  g_object_set(b.element.get(), "max-age", guint64{5}, nullptr);
  EXPECT_EQ(b.picture(kSmall, 4000 * GST_SECOND), small_with({{0, 0, 8, 6}}));
  EXPECT_EQ(b.picture(kSmall, 4000 * GST_SECOND + 6), Bytes(kSmall));
  b.expect_results_balance();
}

TEST(TensorOverlay, KeepsTheLastResultsWhenTheyEnd) {
  const Both b("");
  b.push({1, 1, 7, 6, 1, 0}, 0);
  gst_harness_push_event(b.results.get(), gst_event_new_eos());
  EXPECT_EQ(b.picture(kSmall, kTenth), small_with({{1, 1, 7, 6}}));
  EXPECT_EQ(b.picture(kSmall, GST_SECOND + 1), Bytes(kSmall));
  EXPECT_EQ(gst_harness_events_in_queue(b.pictures.get()), 3u);
  gst_harness_push_event(b.pictures.get(), gst_event_new_eos());
  ASSERT_EQ(gst_harness_events_in_queue(b.pictures.get()), 4u);
  for (int i = 0; i < 3; ++i) gst_event_unref(gst_harness_pull_event(b.pictures.get()));
  const auto last = Ref<GstEvent>::adopt(gst_harness_pull_event(b.pictures.get()));
  EXPECT_EQ(GST_EVENT_TYPE(last.get()), GST_EVENT_EOS);
}

TEST(TensorOverlay, DrawsIntoThePictureItself) {
  const Both b("");
  b.push({1, 1, 7, 6, 1, 0}, 0);
  GstBuffer* in = timed(frame(Bytes(kSmall)), 0);
  ASSERT_EQ(gst_harness_push(b.pictures.get(), in), GST_FLOW_OK);
  const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(b.pictures.get()));
  EXPECT_EQ(out.get(), in);
  EXPECT_EQ(content(out.get()), small_with({{1, 1, 7, 6}}));
  EXPECT_EQ(b.stat("pictures-copied"), 0u);
  EXPECT_EQ(b.stat("bytes-copied"), 0u);
}

TEST(TensorOverlay, CopiesSharedPicturesAndCountsThem) {
  const Both b("");
  b.push({1, 1, 7, 6, 1, 0}, 0);
  const auto check = [&](const Ref<GstBuffer>& kept, GstBuffer* in) {
    ASSERT_EQ(gst_harness_push(b.pictures.get(), in), GST_FLOW_OK);
    const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(b.pictures.get()));
    EXPECT_EQ(content(kept.get()), Bytes(kSmall));
    EXPECT_EQ(content(out.get()), small_with({{1, 1, 7, 6}}));
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), kTenth);
    EXPECT_EQ(GST_BUFFER_DURATION(out.get()), kTenth);
    EXPECT_TRUE(gst_buffer_get_video_region_of_interest_meta_id(out.get(), 0));
  };
  const auto held = Ref<GstBuffer>::adopt(frame(Bytes(kSmall), kTenth, kTenth));
  gst_buffer_add_video_region_of_interest_meta(held.get(), "a", 0, 0, 1, 1);
  check(held, gst_buffer_ref(held.get()));
  check(held, gst_buffer_copy(held.get()));  // another buffer with the same memory
  Bytes still(kSmall);
  const auto read_only = Ref<GstBuffer>::adopt(gst_buffer_new_wrapped_full(
      GST_MEMORY_FLAG_READONLY, still.data(), kSmall, 0, kSmall, nullptr, nullptr));
  GstBuffer* in = gst_buffer_copy(read_only.get());
  GST_BUFFER_PTS(in) = GST_BUFFER_DURATION(in) = kTenth;
  gst_buffer_add_video_region_of_interest_meta(in, "a", 0, 0, 1, 1);
  check(read_only, in);
  EXPECT_EQ(b.stat("pictures-copied"), 3u);
  EXPECT_EQ(b.stat("bytes-copied"), 3 * kSmall);
}

// A decoder pads its pictures, and only GstVideoMeta says where the rows are.
TEST(TensorOverlay, CopiesOfSharedPicturesKeepTheirRows) {
  const Both b("");
  b.push({1, 1, 7, 6, 1, 0}, 0);
  constexpr size_t kFirst = 64, kRow = 40;  // bytes
  gsize offsets[GST_VIDEO_MAX_PLANES] = {kFirst};
  gint strides[GST_VIDEO_MAX_PLANES] = {kRow};
  const auto held = Ref<GstBuffer>::adopt(timed(frame(Bytes(kFirst + 6 * kRow)), 0));
  gst_buffer_add_video_meta_full(held.get(), GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_RGB, 8, 6,
                                 1, offsets, strides);
  ASSERT_EQ(gst_harness_push(b.pictures.get(), gst_buffer_ref(held.get())), GST_FLOW_OK);
  const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(b.pictures.get()));
  EXPECT_NE(out.get(), held.get());
  const GstVideoMeta* layout = gst_buffer_get_video_meta(out.get());
  ASSERT_TRUE(layout);
  EXPECT_EQ(layout->offset[0], kFirst);
  EXPECT_EQ(layout->stride[0], static_cast<gint>(kRow));
  const Bytes all = content(out.get());
  Bytes rows;
  for (size_t y = 0; y < 6; ++y)
    for (size_t x = 0; x < 24; ++x) rows.push_back(all.at(kFirst + y * kRow + x));
  EXPECT_EQ(rows, small_with({{1, 1, 7, 6}}));
  EXPECT_EQ(b.stat("pictures-copied"), 1u);
}

TEST(TensorOverlay, PassesPicturesWithoutResults) {
  const Both b("");
  const auto passes = [&] {
    const auto held = Ref<GstBuffer>::adopt(timed(frame(ramp(kSmall)), 0));
    gst_harness_push(b.pictures.get(), gst_buffer_ref(held.get()));
    const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(b.pictures.get()));
    EXPECT_EQ(out.get(), held.get());
  };
  passes();
  b.push({0, 0, 0, 0, 0, 0}, 0);
  passes();
  EXPECT_EQ(b.stat("bytes-copied"), 0u);
  EXPECT_EQ(b.stat("rows-background"), 1u);
  EXPECT_EQ(b.stat("results-drawn"), 1u);  // results without detections
  EXPECT_EQ(b.stat("pictures-drawn"), 0u);
}

TEST(TensorOverlay, WorksWithoutLinkedResults) {
  const Harness h{gst_harness_new_parse("tensor_overlay sync=same-time")};
  gst_harness_set_src_caps_str(h.get(), video("RGB", 8, 6).c_str());
  const auto out =
      Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), timed(frame(ramp(kSmall)), 0)));
  EXPECT_EQ(content(out.get()), ramp(kSmall));
}

TEST(TensorOverlay, AcceptsOtherSizesAndFormatsWhilePlaying) {
  const Both b("");
  b.push({1, 1, 7, 6, 1, 0}, 0);
  EXPECT_EQ(b.picture(kSmall, 0), small_with({{1, 1, 7, 6}}));
  gst_harness_set_src_caps_str(b.pictures.get(), video("GRAY8", 4, 4).c_str());
  const auto gray =
      draw::to_samples({*preprocess::picture_format("GRAY8")}, draw::class_color(0))[0];
  Bytes expected(16, gray);  // columns 1 and 2 are line, 3 is inside; row 0 and column 0 are not
  for (size_t i = 0; i < 4; ++i) expected[i] = expected[4 * i] = 0;
  expected[15] = 0;
  EXPECT_EQ(b.picture(16, 0), expected);
  gst_harness_set_src_caps_str(b.pictures.get(), video("RGB", 8, 6).c_str());
  EXPECT_EQ(b.picture(kSmall, 0), small_with({{1, 1, 7, 6}}));
  gst_harness_set_src_caps_str(b.results.get(), floats(4, 2).c_str());
  b.push({0, 0, 2, 2, 5, 3, 8, 6}, 0);
  EXPECT_EQ(b.picture(kSmall, 0), small_with({{0, 0, 2, 2}, {5, 3, 8, 6}}));
  EXPECT_EQ(b.stat("dropped"), 0u);
}

TEST(TensorOverlay, AppliesPropertiesWhilePlaying) {
  const Both b("line-width=0 point-size=0", video("RGB", 8, 6), floats(8, 1));
  b.push({0, 0, 8, 6, 0.5f, 0, 4, 3}, 0);
  EXPECT_EQ(b.picture(kSmall, 0), Bytes(kSmall));
  g_object_set(b.element.get(), "line-width", 2u, nullptr);
  EXPECT_EQ(b.picture(kSmall, 0), small_with({{0, 0, 8, 6}}));
  g_object_set(b.element.get(), "line-width", 0u, "point-size", 2u, nullptr);
  EXPECT_EQ(b.picture(kSmall, 0), small_with({{3, 2, 5, 4}}));
  g_object_set(b.element.get(), "min-score", 0.6, nullptr);
  EXPECT_EQ(b.picture(kSmall, 0), Bytes(kSmall));
  EXPECT_EQ(b.stat("boxes-below-score"), 1u);
}

// The width of the left line of a box as large as the picture, in its middle row.
int line_width(const std::string& properties, int height) {
  const Both b("auto-size=true " + properties, video("GRAY8", 100, height), floats(6, 1));
  b.push({0, 0, 100, static_cast<float>(height), 0.5f, 0}, 0);
  const Bytes picture = b.picture(size_t{100} * static_cast<size_t>(height), 0);
  int count = 0;
  while (count < 50 && picture[static_cast<size_t>(height / 2 * 100 + count)] != 0) ++count;
  return count;
}

TEST(TensorOverlay, LinesFollowTheHeightOfThePictureUnlessTheyAreSet) {
  EXPECT_EQ(line_width("", 720), 2);
  EXPECT_EQ(line_width("", 1440), 4);
  EXPECT_EQ(line_width("", 240), 1);
  EXPECT_EQ(line_width("line-width=2", 1440), 2) << "set to its default";
  EXPECT_EQ(line_width("line-width=0", 1440), 0);
  EXPECT_EQ(line_width("point-size=2", 1440), 4);
  EXPECT_EQ(line_width("auto-size=false", 1440), 2);
}

TEST(TensorOverlay, SizesFollowThePictureByDefault) {
  const auto element = lone_element("tensor_overlay");
  gboolean follows = FALSE;
  g_object_get(element.get(), "auto-size", &follows, nullptr);
  EXPECT_TRUE(follows);
}

TEST(TensorOverlay, ForgetsResultsWhenEitherStreamIsFlushed) {
  const Both b("");
  for (const Harness* flushed : {&b.pictures, &b.results}) {
    b.push({1, 1, 7, 6, 1, 0}, 0);
    gst_harness_push_event(flushed->get(), gst_event_new_flush_start());
    gst_harness_push_event(flushed->get(), gst_event_new_flush_stop(TRUE));
    gst_harness_push_event(flushed->get(), time_segment());
    EXPECT_EQ(b.picture(kSmall, 0), Bytes(kSmall));
    b.push({1, 1, 7, 6, 1, 0}, 0);
    EXPECT_EQ(b.picture(kSmall, 0), small_with({{1, 1, 7, 6}}));
  }
  EXPECT_EQ(b.stat("results-flushed"), 2u);
  b.expect_results_balance();
}

TEST(TensorOverlay, MapsTensorCoordinatesToThePicture) {
  const Both b("coordinates=tensor");
  const auto push = [&](uint32_t width, uint32_t height) {
    GstBuffer* results = frame<float>({10, 20, 22, 40, 1, 0}, 0);
    SourceMap map;
    map.xx = 0.5, map.x0 = -4, map.yy = 0.25, map.y0 = -4;
    map.source_width = width;
    map.source_height = height;
    gst::set_source_maps(results, {map});
    return gst_harness_push(b.results.get(), results);
  };
  ASSERT_EQ(push(8, 6), GST_FLOW_OK);
  EXPECT_EQ(b.picture(kSmall, 0), small_with({{1, 1, 7, 6}}));
  ASSERT_EQ(push(16, 6), GST_FLOW_OK);  // the source was twice as wide as this video
  EXPECT_EQ(b.picture(kSmall, 0), small_with({{1, 1, 4, 6}}));
}

TEST(TensorOverlay, KeepsToTheRowsOfItsBuffer) {
  const Both b("", video("RGB", 4, 4));
  b.push({0, 0, 4, 4, 1, 0}, 0);
  GstBuffer* in = timed(frame(Bytes(8 * 6 * 3)), 0);  // a crop, in a picture of 8x6
  gsize offsets[GST_VIDEO_MAX_PLANES] = {0};
  gint strides[GST_VIDEO_MAX_PLANES] = {24};
  gst_buffer_add_video_meta_full(in, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_RGB, 4, 4, 1,
                                 offsets, strides);
  EXPECT_EQ(b.pushed(in), small_with({{0, 0, 4, 4}}));
}

// Draws into all memories that a picture spans, with and without GstVideoMeta.
TEST(TensorOverlay, DrawsIntoAPictureOfSeveralMemories) {
  for (const bool with_meta : {true, false}) {
    const Both b("");
    b.push({1, 1, 7, 6, 1, 0}, 0);
    GstBuffer* in = gst_buffer_new();
    for (const size_t bytes : {size_t{25}, size_t{1}, kSmall - 26})
      gst_buffer_append_memory(in, make_memory(Bytes(bytes)));
    gsize offsets[GST_VIDEO_MAX_PLANES] = {0};
    gint strides[GST_VIDEO_MAX_PLANES] = {24};
    if (with_meta)
      gst_buffer_add_video_meta_full(in, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_RGB, 8, 6, 1,
                                     offsets, strides);
    EXPECT_EQ(b.pushed(timed(in, 0)), small_with({{1, 1, 7, 6}})) << with_meta;
    EXPECT_EQ(b.stat("bytes-copied"), kSmall) << with_meta;
  }
}

// Random bits as numbers, in every format; memory of exactly the picture's size.
TEST(TensorOverlay, SurvivesAnyCoordinates) {
  uint32_t state = 7;
  const auto random = [&state] { return state = state * 1664525u + 1013904223u; };
  constexpr int kRows = 10000;
  for (const char* format :
       {"RGB", "BGRx", "GRAY8", "NV12", "NV21", "I420", "YV12", "YUY2", "UYVY"}) {
    const Both b("line-width=9 point-size=30", video(format, 33, 17), floats(10, kRows));
    GstVideoInfo info;
    gst_video_info_set_format(&info, gst_video_format_from_string(format), 33, 17);
    for (const bool near : {false, true}) {
      std::vector<float> numbers(10 * kRows);
      for (float& number : numbers) {
        const uint32_t bits = random();
        if (near)
          number = static_cast<float>(bits % 4000) / 40 - 30;
        else
          std::memcpy(&number, &bits, sizeof number);
      }
      ASSERT_EQ(b.push(numbers, 0), GST_FLOW_OK);
      EXPECT_EQ(b.picture(info.size, 0).size(), info.size);
    }
    EXPECT_GT(b.stat("rows-not-finite"), 0u);
    EXPECT_GT(b.stat("rows-without-area"), 0u);
    EXPECT_GT(b.stat("boxes-drawn"), 0u);
    EXPECT_EQ(b.stat("pictures-drawn"), 2u);
  }
}

TEST(TensorOverlay, DrawsNoMoreRowsThanItsLimit) {
  const Both b("", video("RGB", 8, 6), floats(4, 10001));
  std::vector<float> numbers;
  for (int i = 0; i < 10001; ++i) numbers.insert(numbers.end(), {0, 0, 1, 1});
  b.push(numbers, 0);
  EXPECT_EQ(b.picture(kSmall, 0), small_with({{0, 0, 1, 1}}));
  EXPECT_EQ(b.stat("rows-beyond-limit"), 1u);
  EXPECT_EQ(b.stat("boxes-drawn"), 10000u);
}

}  // namespace tensor_overlay_test
}  // namespace weir::overlay_test
