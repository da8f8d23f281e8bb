// Regions from metadata, resized and batched.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>
#include <optional>

#include "core/tensor/tensor_header.hpp"
#include "elements/tensor_preprocess/preprocess_test_support.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir::preprocess_test {
namespace regions_test {

struct Box {
  guint x, y, width, height;
};
constexpr guint kMax = G_MAXUINT;

GstBuffer* with_boxes(GstBuffer* in, const std::vector<Box>& boxes) {
  for (const Box& b : boxes)
    gst_buffer_add_video_region_of_interest_meta(in, "face", b.x, b.y, b.width, b.height);
  return in;
}
Ref<GstBuffer> push_and_pull(const Harness& h, GstBuffer* in) {
  EXPECT_EQ(gst_harness_push(h.get(), in), GST_FLOW_OK);
  return Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
}
Bytes read_bytes(GstBuffer* buffer, size_t from = 0) {
  const Mapped map(buffer, GST_MAP_READ);
  const auto span = map.as<const uint8_t>().subspan(from);
  return {span.begin(), span.end()};
}
std::optional<TensorSpec> read_header(GstBuffer* buffer) {
  const Mapped map(buffer, GST_MAP_READ);
  const auto header = read_tensor_chunk(std::as_bytes(map.as<const uint8_t>()));
  if (!header) return std::nullopt;
  return header->spec;
}
// The output of the element without regions for the same part.
Bytes single(const std::string& properties, const std::string& caps, GstBuffer* in,
             const Box& part) {
  auto h = harness(properties, caps);
  crop(in, part.x, part.y, part.width, part.height);
  return pushed<uint8_t>(h, in);
}

TEST(Regions, MatchTheirPartsConvertedSeparately) {
  const Box boxes[] = {
      {0, 0, 64, 36}, {5, 7, 31, 13}, {63, 35, 1, 1}, {2, 3, 9, 33}, {10, 1, 7, 5}};
  for (const std::string format : {"RGB", "GRAY8", "NV12", "NV21", "I420", "YV12", "YUY2", "UYVY"})
    for (const std::string more : {" method=area", " fit=letterbox mean=3 layout=NCHW",
                                   " threads=3 method=nearest fit=centre-crop"}) {
      const std::string size = "width=7 height=5" + more;
      const auto caps = video(format, 64, 36);
      auto h = harness("regions=meta " + size, caps);
      EXPECT_SAYS(caps_text(h), "format=(string)flexible");
      // The number varies by frame: plans adapt to other regions.
      for (const size_t count : {2u, 5u, 1u, 4u, 5u}) {
        const size_t first = 5 - count;
        const auto out = push_and_pull(h, with_boxes(frame(ramp(frame_bytes(format, 64, 36))),
                                                     {boxes + first, boxes + first + count}));
        ASSERT_TRUE(out);
        Bytes wanted;
        for (size_t i = first; i < 5; ++i)
          for (const uint8_t byte :
               single(size, caps, frame(ramp(frame_bytes(format, 64, 36))), boxes[i]))
            wanted.push_back(byte);
        ASSERT_FALSE(wanted.empty());
        EXPECT_EQ(read_bytes(out.get(), kTensorHeaderBytes), wanted) << format << more << count;
        const auto spec = read_header(out.get());
        ASSERT_TRUE(spec);
        EXPECT_EQ(spec->shape[3], count);
        EXPECT_EQ(spec->shape[0], more.find("NCHW") == std::string::npos ? 3u : 7u);
      }
      EXPECT_EQ(stat(h, "regions"), 17u);
      EXPECT_EQ(stat(h, "pushed"), 5u);
    }
}

TEST(Regions, HaveTheirSourceMapsInOrder) {
  auto h = harness("regions=meta width=10 height=4", video("GRAY8", 64, 36));
  const auto out = push_and_pull(
      h, with_boxes(frame(ramp(64 * 36)), {{30, 20, 20, 8}, {60, 30, 100, 100}, {1, 2, 5, 8}}));
  ASSERT_TRUE(out);
  const auto maps = gst::source_maps(out.get());
  ASSERT_EQ(maps.size(), 3u);
  EXPECT_EQ(maps[0].source_width, 64u);
  EXPECT_EQ(maps[0].width, 10u);
  EXPECT_DOUBLE_EQ(maps[0].to_source({5, 1}).x, 40);
  EXPECT_DOUBLE_EQ(maps[0].to_source({5, 1}).y, 22);
  EXPECT_DOUBLE_EQ(maps[1].to_source({10, 4}).x, 64);  // clipped to 4x6
  EXPECT_DOUBLE_EQ(maps[1].to_source({10, 4}).y, 36);
  EXPECT_DOUBLE_EQ(maps[2].to_source({0, 0}).x, 1);
  EXPECT_DOUBLE_EQ(maps[2].to_source({10, 2}).y, 6);
}

TEST(Regions, OutsideThePictureAreClippedOrSkippedAndCounted) {
  auto h = harness("regions=meta width=2 height=1 channel-order=GRAY", video("GRAY8", 4, 3));
  const auto out = push_and_pull(h, with_boxes(frame(ramp(12)), {{4, 0, 1, 1},
                                                                 {0, 3, 2, 1},
                                                                 {1, 1, 0, 1},
                                                                 {kMax, kMax, kMax, kMax},
                                                                 {2, 2, kMax, kMax},
                                                                 {kMax, 0, 3, 3},
                                                                 {1, 0, 2, 1}}));
  ASSERT_TRUE(out);
  EXPECT_EQ(read_bytes(out.get(), kTensorHeaderBytes), (Bytes{10, 11, 1, 2}));
  EXPECT_EQ(stat(h, "regions"), 2u);
  EXPECT_EQ(stat(h, "regions-empty"), 5u);
  EXPECT_EQ(stat(h, "regions-beyond-limit"), 0u);
}

TEST(Regions, KeepTheirProportionsWithPaddingOutsideThePicture) {
  auto h = harness(
      "regions=meta clip-regions=false method=nearest padding-value=7 width=4 height=2 "
      "channel-order=GRAY",
      video("GRAY8", 4, 3));
  const auto out = push_and_pull(
      h, with_boxes(
             frame(ramp(12)),
             {{2, 2, 4, 2}, {0, 0, 4, 2}, {4, 0, 1, 1}, {kMax, kMax, kMax, kMax}, {3, 0, 2, 4}}));
  ASSERT_TRUE(out);
  EXPECT_EQ(read_bytes(out.get(), kTensorHeaderBytes),
            (Bytes{10, 11, 7, 7, 7, 7, 7, 7, 0, 1, 2, 3, 4, 5, 6, 7, 3, 3, 7, 7, 7, 7, 7, 7}))
      << "the middle of the last row is at 3, just below the picture";
  EXPECT_EQ(stat(h, "regions"), 3u);
  EXPECT_EQ(stat(h, "regions-empty"), 2u);
  const auto maps = gst::source_maps(out.get());
  ASSERT_EQ(maps.size(), 3u);
  EXPECT_DOUBLE_EQ(maps[0].to_source({4, 2}).x, 6);
  EXPECT_DOUBLE_EQ(maps[0].to_source({4, 2}).y, 4);
  EXPECT_DOUBLE_EQ(maps[2].to_source({0, 0}).x, 3);
  EXPECT_DOUBLE_EQ(maps[2].to_source({4, 2}).y, 4);
}

TEST(Regions, ArePaddedOutsideTheCropOfThePicture) {
  auto h =
      harness("regions=meta clip-regions=false padding-value=7 width=2 height=1 channel-order=GRAY",
              video("GRAY8", 4, 3));
  GstBuffer* in = with_boxes(frame(ramp(12)), {{0, 1, 2, 1}, {3, 2, 2, 1}});
  crop(in, 1, 1, 3, 2);
  const auto out = push_and_pull(h, in);
  ASSERT_TRUE(out);
  EXPECT_EQ(read_bytes(out.get(), kTensorHeaderBytes), (Bytes{7, 5, 11, 7}));
}

TEST(Regions, AreRelativeToThePictureInMemory) {
  auto h = harness("regions=meta width=2 height=1 channel-order=GRAY", video("GRAY8", 4, 3));
  GstBuffer* in = with_boxes(frame(ramp(12)), {{0, 0, 3, 2}, {0, 0, 1, 1}});
  crop(in, 1, 1, 3, 2);
  const auto out = push_and_pull(h, in);
  ASSERT_TRUE(out);
  EXPECT_EQ(read_bytes(out.get(), kTensorHeaderBytes), (Bytes{5, 6}));
  EXPECT_EQ(stat(h, "regions-empty"), 1u);
  const auto text = get_error(h, [&] {
    GstBuffer* bad = with_boxes(frame(ramp(12)), {{0, 0, 1, 1}});
    crop(bad, 3, 0, 2, 1);
    EXPECT_EQ(gst_harness_push(h.get(), bad), GST_FLOW_ERROR);
  });
  EXPECT_SAYS(text, "the crop exceeds the picture");
  EXPECT_EQ(stat(h, "dropped-error"), 1u);
}

TEST(Regions, WithoutEntriesAreACountedGap) {
  for (const char* mode : {"", " max-regions=3"}) {
    auto h = harness(std::string("regions=meta width=2 height=1") + mode, video("RGB", 4, 3));
    GstBuffer* in = with_boxes(frame(ramp(36)), {{4, 0, 1, 1}});
    GST_BUFFER_PTS(in) = 5 * GST_SECOND;
    GST_BUFFER_DURATION(in) = GST_SECOND;
    EXPECT_FALSE(push_and_pull(h, in));
    bool gap = false;
    while (const auto event = Ref<GstEvent>::adopt(gst_harness_try_pull_event(h.get()))) {
      if (GST_EVENT_TYPE(event.get()) != GST_EVENT_GAP) continue;
      GstClockTime time = 0, duration = 0;
      gst_event_parse_gap(event.get(), &time, &duration);
      EXPECT_EQ(time, 5 * GST_SECOND);
      EXPECT_EQ(duration, GST_SECOND);
      gap = true;
    }
    EXPECT_TRUE(gap);
    EXPECT_FALSE(push_and_pull(h, frame(ramp(36))));  // without a time: no GAP, no error
    EXPECT_EQ(stat(h, "received"), 2u);
    EXPECT_EQ(stat(h, "dropped-policy"), 2u);
    EXPECT_EQ(stat(h, "held"), 0u);
    EXPECT_EQ(stat(h, "regions-empty"), 1u);
    EXPECT_TRUE(push_and_pull(h, with_boxes(frame(ramp(36)), {{0, 0, 1, 1}})));
    EXPECT_EQ(stat(h, "pushed"), 1u);
  }
}

TEST(Regions, AreAsManyAsTheFrameHas) {
  auto h = harness("regions=meta width=3 height=1 type=uint8 channel-order=GRAY",
                   video("GRAY8", 60, 60));
  std::vector<Box> boxes;
  Bytes wanted;
  for (guint i = 0; i < 300; ++i) {
    const Box box{i % 50, i / 6, 3, 1};
    boxes.push_back(box);
    for (guint x = 0; x < 3; ++x) wanted.push_back(static_cast<uint8_t>(box.y * 60 + box.x + x));
  }
  const auto out = push_and_pull(h, with_boxes(frame(ramp(3600)), boxes));
  ASSERT_TRUE(out);
  EXPECT_EQ(read_bytes(out.get(), kTensorHeaderBytes), wanted);
  EXPECT_EQ(gst::source_maps(out.get()).size(), 300u);
  EXPECT_EQ(read_header(out.get())->to_string(), "uint8 1:3:1:300");
}

TEST(Regions, HaveALimit) {
  auto h = harness("regions=meta width=1 height=1", video("GRAY8", 4, 3));
  const auto out =
      push_and_pull(h, with_boxes(frame(ramp(12)), std::vector<Box>(4100, Box{1, 1, 1, 1})));
  ASSERT_TRUE(out);
  EXPECT_EQ(read_header(out.get())->shape[3], 4096u);
  EXPECT_EQ(stat(h, "regions-beyond-limit"), 4u);
}

TEST(Regions, FillAStaticBatch) {
  auto h = harness("regions=meta max-regions=3 width=2 height=1 channel-order=GRAY",
                   video("GRAY8", 4, 3));
  const Bytes cases[] = {
      {0, 1, 0, 0, 0, 0}, {0, 1, 1, 2, 2, 3}, {0, 1, 1, 2, 2, 3}, {0, 1, 1, 2, 0, 0}};
  const size_t counts[] = {1, 3, 5, 2};
  const std::vector<Box> boxes{
      {0, 0, 2, 1}, {1, 0, 2, 1}, {2, 0, 2, 1}, {0, 1, 2, 1}, {0, 2, 2, 1}};
  for (size_t i = 0; i < 4; ++i) {
    const auto out =
        push_and_pull(h, with_boxes(frame(ramp(12)), {boxes.begin(), boxes.begin() + counts[i]}));
    ASSERT_TRUE(out);
    EXPECT_EQ(read_bytes(out.get()), cases[i]);
    EXPECT_EQ(gst::source_maps(out.get()).size(), std::min<size_t>(counts[i], 3));
  }
  EXPECT_SAYS(caps_text(h), "format=(string)static");
  EXPECT_SAYS(caps_text(h), "1:2:1:3");
  EXPECT_EQ(stat(h, "regions"), 9u);
  EXPECT_EQ(stat(h, "regions-beyond-limit"), 2u);
  EXPECT_EQ(stat(h, "pool-allocated"), 1u);
}

TEST(Regions, TakeTheSizeOfAStaticBatchFromDownstream) {
  Harness h{gst_harness_new_parse("tensor_preprocess regions=meta max-regions=2")};
  gst_harness_set_sink_caps_str(h.get(),
                                "other/tensors,format=static,num_tensors=1,dimensions=(string)"
                                "4:3:3:2,types=(string)float32,framerate=10/1");
  gst_harness_set_src_caps_str(h.get(), video("RGB", 8, 6).c_str());
  const auto out = push_and_pull(h, with_boxes(frame(ramp(144)), {{0, 0, 8, 6}}));
  ASSERT_TRUE(out);
  EXPECT_EQ(gst_buffer_get_size(out.get()), 4u * 3 * 3 * 2 * 4);
}

TEST(Regions, RejectInvalidCombinations) {
  EXPECT_SAYS(error_of_start("regions=meta sizes=4x4"), "regions have one size");
  EXPECT_SAYS(error_of_start("max-regions=4"), "max-regions without regions has no effect");
  EXPECT_SAYS(error_of_start("clip-regions=false"), "clip-regions without regions has no effect");
  EXPECT_SAYS(error_with_caps("regions=meta", video("RGB", 8, 6)),
              "the size of the tensor is unknown");
  const char* four =
      "other/tensors,format=static,num_tensors=1,dimensions=(string)3:4:3:4,"
      "types=(string)uint8,framerate=10/1";
  const auto other =
      error_with_caps("regions=meta max-regions=2 width=4 height=3", video("RGB", 8, 6), four);
  EXPECT_SAYS(other, "the element downstream of tensor_preprocess needs another tensor");
  EXPECT_SAYS(other, "3:4:3:2");
  const auto flexible = error_with_caps("regions=meta width=4 height=3", video("RGB", 8, 6), four);
  EXPECT_SAYS(flexible, "format=(string)flexible");
  EXPECT_SAYS(flexible, "max-regions");
}

TEST(Regions, OfAFrameThatIsTooShortAreRejected) {
  auto h = harness("regions=meta width=2 height=1", video("RGB", 4, 3));
  const auto text = get_error(h, [&] {
    EXPECT_EQ(gst_harness_push(h.get(), with_boxes(frame(ramp(35)), {{0, 0, 1, 1}})),
              GST_FLOW_ERROR);
  });
  EXPECT_SAYS(text, "offered: 35 bytes");
  EXPECT_EQ(stat(h, "dropped-error"), 1u);
}

}  // namespace regions_test
}  // namespace weir::preprocess_test
