// Regions from boxes on a second pad.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>
#include <numbers>
#include <thread>

#include "core/tensor/tensor_header.hpp"
#include "elements/tensor_preprocess/preprocess_test_support.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir::preprocess_test {
namespace regions_pad_test {

constexpr const char* kBoxes =
    "other/tensors,format=static,num_tensors=1,dimensions=(string)\"4:2\",types=(string)uint32,"
    "framerate=10/1";

GstBuffer* timed(GstBuffer* buffer, GstClockTime time) {
  GST_BUFFER_PTS(buffer) = time;
  return buffer;
}
template <class Number>
GstBuffer* boxes(const std::vector<Number>& numbers, GstClockTime time) {
  GstBuffer* b = gst_buffer_new_allocate(nullptr, numbers.size() * sizeof(Number), nullptr);
  gst_buffer_fill(b, 0, numbers.data(), numbers.size() * sizeof(Number));
  return timed(b, time);
}

struct Both {
  Harness pictures, regions;
};
Both both(const std::string& properties, const char* caps = kBoxes) {
  GstElement* element = gst_parse_launch(
      ("tensor_preprocess channel-order=GRAY width=2 height=1 regions=pad " + properties).c_str(),
      nullptr);
  const auto held = Ref<GstElement>::adopt(GST_ELEMENT(gst_object_ref_sink(element)));
  gst_object_unref(gst_element_request_pad_simple(element, "regions"));
  Both out{Harness{gst_harness_new_with_element(element, "sink", "src")},
           Harness{gst_harness_new_with_element(element, "regions", nullptr)}};
  gst_harness_set_src_caps_str(out.regions.get(), caps);
  gst_harness_set_src_caps_str(out.pictures.get(), video("GRAY8", 4, 3).c_str());
  return out;
}
Bytes pulled(const Harness& h) {
  const auto out = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
  if (!out) return {};
  const Mapped map(out.get(), GST_MAP_READ);
  const auto span = map.as<const uint8_t>();
  return {span.begin(), span.end()};
}

TEST(RegionsPad, PadsBoxesThatStartOutsideThePicture) {
  auto b = both("max-regions=2 clip-regions=false padding-value=9",
                "other/tensors,format=static,num_tensors=1,dimensions=(string)\"4:2\","
                "types=(string)float32,framerate=10/1");
  ASSERT_EQ(gst_harness_push(b.regions.get(), boxes<float>({-1, 0, 2, 1, 1, -1, 2, 1}, 0)),
            GST_FLOW_OK);
  ASSERT_EQ(gst_harness_push(b.pictures.get(), timed(frame(ramp(12)), 0)), GST_FLOW_OK);
  EXPECT_EQ(pulled(b.pictures), (Bytes{9, 0, 0, 0})) << "the second is outside, its row is empty";
  EXPECT_EQ(stat(b.pictures, "regions-empty"), 1u);
}

TEST(RegionsPad, CropsTheBoxesOfTheSameTime) {
  auto b = both("max-regions=2");
  for (const uint32_t i : {0u, 1u, 2u})
    ASSERT_EQ(gst_harness_push(b.regions.get(),
                               boxes<uint32_t>({i, i, 2, 1, 0, 2, 2, 1}, i * GST_SECOND)),
              GST_FLOW_OK);
  for (const uint8_t i : {uint8_t{0}, uint8_t{2}}) {
    ASSERT_EQ(gst_harness_push(b.pictures.get(), timed(frame(ramp(12)), i * GST_SECOND)),
              GST_FLOW_OK);
    const auto first = static_cast<uint8_t>(5 * i);
    EXPECT_EQ(pulled(b.pictures), (Bytes{first, static_cast<uint8_t>(first + 1), 8, 9}));
  }
  EXPECT_EQ(stat(b.pictures, "boxes-unused"), 1u);
  EXPECT_EQ(stat(b.pictures, "pushed"), 2u);
}

TEST(RegionsPad, WaitsForBoxesOfAnotherThread) {
  auto b = both("max-regions=2 max-wait=100000000000");
  std::thread other([&] {
    for (uint32_t i = 0; i < 200; ++i) {
      if (i % 4 == 3) continue;  // no object in this picture
      gst_harness_push(b.regions.get(), boxes<uint32_t>({i % 3, 0, 2, 1, 9, 9, 1, 1}, i * 1000));
    }
    gst_harness_push_event(b.regions.get(), gst_event_new_eos());
  });
  for (uint32_t i = 0; i < 200; ++i) {
    EXPECT_EQ(gst_harness_push(b.pictures.get(), timed(frame(ramp(12)), i * 1000)), GST_FLOW_OK);
    const auto out = pulled(b.pictures);
    if (i % 4 == 3) {
      EXPECT_TRUE(out.empty());
      continue;
    }
    ASSERT_EQ(out.size(), 4u);
    EXPECT_EQ(out[0], i % 3);
  }
  other.join();
  EXPECT_EQ(stat(b.pictures, "received"), 200u);
  EXPECT_EQ(stat(b.pictures, "dropped-policy"), 50u);
  EXPECT_EQ(stat(b.pictures, "boxes-unused"), 0u);
  EXPECT_EQ(stat(b.pictures, "boxes-late"), 0u);
}

TEST(RegionsPad, AcceptsFlexibleStreamsOfFloats) {
  auto b = both("", "other/tensors,format=flexible,framerate=10/1");
  TensorHeader header;
  header.spec = {ElementType::Float32, {4, 3}, ""};
  std::vector<std::byte> bytes(kTensorHeaderBytes + 3 * 16);
  write_tensor_header(header, std::span(bytes).first<kTensorHeaderBytes>());
  const float numbers[] = {-1, 0.4f, 3, 1, 1.2f, 1.6f, 2, 0.9f, 0, 0, 0.2f, 1};
  std::memcpy(bytes.data() + kTensorHeaderBytes, numbers, sizeof(numbers));
  ASSERT_EQ(gst_harness_push(b.regions.get(), boxes(bytes, 0)), GST_FLOW_OK);
  ASSERT_EQ(gst_harness_push(b.pictures.get(), timed(frame(ramp(12)), 0)), GST_FLOW_OK);
  const auto out = pulled(b.pictures);
  ASSERT_EQ(out.size(), kTensorHeaderBytes + 4);
  EXPECT_EQ(Bytes(out.end() - 4, out.end()), (Bytes{0, 1, 9, 10}));
  EXPECT_EQ(stat(b.pictures, "regions-empty"), 1u);
}

TEST(RegionsPad, DropsPicturesWithoutBoxesInTime) {
  auto b = both("max-regions=1 max-wait=1");
  ASSERT_EQ(gst_harness_push(b.pictures.get(), timed(frame(ramp(12)), 0)), GST_FLOW_OK);
  ASSERT_EQ(gst_harness_push(b.pictures.get(), frame(ramp(12))), GST_FLOW_OK);  // without a time
  EXPECT_TRUE(pulled(b.pictures).empty());
  EXPECT_EQ(stat(b.pictures, "boxes-late"), 1u);
  EXPECT_EQ(stat(b.pictures, "dropped-policy"), 2u);
  gst_harness_push_event(b.regions.get(), gst_event_new_gap(0, 2 * GST_SECOND));
  ASSERT_EQ(gst_harness_push(b.pictures.get(), timed(frame(ramp(12)), GST_SECOND)), GST_FLOW_OK);
  EXPECT_EQ(stat(b.pictures, "boxes-late"), 1u);  // the GAP means that there are none
}

TEST(RegionsPad, FindsNoTimeInByteSegments) {
  auto b = both("max-regions=2 max-wait=1");
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_BYTES);
  gst_harness_push_event(b.regions.get(), gst_event_new_segment(&segment));
  ASSERT_EQ(
      gst_harness_push(b.regions.get(), boxes<uint32_t>({0, 0, 2, 1, 0, 2, 2, 1}, GST_SECOND)),
      GST_FLOW_OK);
  gst_harness_push_event(b.regions.get(), gst_event_new_gap(0, 1));
  ASSERT_EQ(gst_harness_push(b.pictures.get(), timed(frame(ramp(12)), GST_SECOND)), GST_FLOW_OK);
  EXPECT_TRUE(pulled(b.pictures).empty());
  EXPECT_EQ(stat(b.pictures, "boxes-unused"), 1u);
  EXPECT_EQ(stat(b.pictures, "dropped-policy"), 1u);
}

TEST(RegionsPad, ReleasesAWaitingPictureOnStop) {
  auto b = both("max-regions=1 max-wait=86400000000000");
  std::thread pictures([&] {
    EXPECT_EQ(gst_harness_push(b.pictures.get(), timed(frame(ramp(12)), 0)), GST_FLOW_FLUSHING);
  });
  const auto e =
      Ref<GstElement>::adopt(gst_harness_find_element(b.pictures.get(), "tensor_preprocess"));
  wait_for_stat(b.pictures, "tensor_preprocess", "received", 1);
  gst_element_set_state(e.get(), GST_STATE_NULL);
  pictures.join();
}

TEST(RegionsPad, PushesAWaitingPictureWhenTheBoxesAreFlushed) {
  auto b = both("max-regions=1 max-wait=86400000000000");
  std::thread pictures([&] {
    EXPECT_EQ(gst_harness_push(b.pictures.get(), timed(frame(ramp(12)), 0)), GST_FLOW_OK);
  });
  wait_for_stat(b.pictures, "tensor_preprocess", "received", 1);
  gst_harness_push_event(b.regions.get(), gst_event_new_flush_start());
  pictures.join();
  EXPECT_EQ(stat(b.pictures, "dropped-policy"), 1u);
}

TEST(RegionsPad, RejectsInvalidBoxes) {
  for (const char* tensor : {"dimensions=(string)\"5:2\",types=(string)uint32",
                             "dimensions=(string)\"4:2\",types=(string)int32"}) {
    auto b = both("");
    const auto text = get_error(b.pictures, [&] {
      gst_harness_set_src_caps_str(
          b.regions.get(),
          (std::string("other/tensors,format=static,num_tensors=1,framerate=10/1,") + tensor)
              .c_str());
    });
    EXPECT_SAYS(text, "the stream of regions does not contain boxes");
    EXPECT_SAYS(text, "x, y, width and height of each box");
  }
  auto b = both("");
  const auto text = get_error(b.pictures, [&] {
    EXPECT_EQ(gst_harness_push(b.regions.get(), boxes<uint32_t>({1, 2}, 0)), GST_FLOW_ERROR);
  });
  EXPECT_SAYS(text, "WEIR-");
}

TEST(RegionsPad, RequiresItsProperty) {
  EXPECT_SAYS(error_of_start("regions=pad"), "there is no stream of boxes");
  EXPECT_SAYS(error_of_start("name=p fakesrc ! p.regions"), "the stream of boxes is not used");
}

// A stream of results with these columns, a frame of one tensor of float32 rows.
std::string results_caps(const std::string& columns, const std::string& dimensions) {
  return "other/tensors,format=static,num_tensors=1,dimensions=(string)\"" + dimensions +
         "\",types=(string)float32,framerate=10/1,weir-columns=(string)\"" + columns + "\"";
}

TEST(RegionsPad, TakesTheBoxesOfResultsWithTheNumbersOfTheirRows) {
  auto b = both("max-regions=2", results_caps("x1,y1,x2,y2,score", "5:3").c_str());
  ASSERT_EQ(gst_harness_push(b.regions.get(),
                             boxes<float>({1, 1, 3, 2, 0.5f, 0, 0, 4, 3, 0, 0, 2, 2, 3, 0.9f}, 0)),
            GST_FLOW_OK);
  ASSERT_EQ(gst_harness_push(b.pictures.get(), timed(frame(ramp(12)), 0)), GST_FLOW_OK);
  const auto out = Ref<GstBuffer>::adopt(gst_harness_try_pull(b.pictures.get()));
  ASSERT_TRUE(out);
  EXPECT_EQ(values<uint8_t>(out.get()), (Bytes{5, 6, 8, 9}));
  const auto maps = gst::source_maps(out.get());
  ASSERT_EQ(maps.size(), 2u);
  EXPECT_EQ(maps[0].row, 1u);
  EXPECT_EQ(maps[1].row, 3u) << "the second row is background";
}

TEST(RegionsPad, ScalesTheBoxesOfResultsFromAPictureOfAnotherSize) {
  auto b = both("max-regions=1", results_caps("x1,y1,x2,y2,score", "5:1").c_str());
  GstBuffer* in = boxes<float>({100, 100, 300, 200, 1}, 0);
  gst::set_source_maps(in, {picture_as_it_is(400, 300, true)});
  ASSERT_EQ(gst_harness_push(b.regions.get(), in), GST_FLOW_OK);
  ASSERT_EQ(gst_harness_push(b.pictures.get(), timed(frame(ramp(12)), 0)), GST_FLOW_OK);
  EXPECT_EQ(pulled(b.pictures), (Bytes{5, 6})) << "the picture is 4 x 3";
}

// The left half of a picture of 8 x 3 has been cut off.
TEST(RegionsPad, LeavesTheBoxesOfAnotherPartOfThePicture) {
  auto b = both("max-regions=1", results_caps("x1,y1,x2,y2,score", "5:1").c_str());
  Errors errors(b.pictures);
  for (const GstClockTime time : {0, 1}) {
    GstBuffer* in = boxes<float>({1, 1, 3, 2, 1}, time);
    gst::set_source_maps(in, {picture_as_it_is(8, 3, true)});
    ASSERT_EQ(gst_harness_push(b.regions.get(), in), GST_FLOW_OK);
    ASSERT_EQ(gst_harness_push(b.pictures.get(), timed(frame(ramp(12)), time)), GST_FLOW_OK);
    EXPECT_EQ(pulled(b.pictures), (Bytes{5, 6}));
  }
  const auto warning = errors.next_warning();
  EXPECT_SAYS(warning, "results of a picture of 8 x 3");
  EXPECT_SAYS(warning, "needed: 4 x 3 or the same proportions");
  EXPECT_SAYS(warning, "crop=LEFT:TOP:WIDTH:HEIGHT of tensor_preprocess");
  EXPECT_EQ(errors.next_warning(), "") << "once per stream";
}

// The pixels of the picture are twice as wide as those of the picture of 80 x 30.
TEST(RegionsPad, ShapesBoxesInItsOwnPicture) {
  auto b = both("max-regions=1 clip-regions=false square-regions=true",
                results_caps("x1,y1,x2,y2,score", "5:1").c_str());
  gst_harness_set_src_caps_str(b.pictures.get(),
                               (video("GRAY8", 4, 3) + ",pixel-aspect-ratio=2/1").c_str());
  GstBuffer* in = boxes<float>({20, 10, 40, 30, 1}, 0);
  gst::set_source_maps(in, {picture_as_it_is(80, 30, true)});
  ASSERT_EQ(gst_harness_push(b.regions.get(), in), GST_FLOW_OK);
  ASSERT_EQ(gst_harness_push(b.pictures.get(), timed(frame(ramp(12)), 0)), GST_FLOW_OK);
  const auto out = Ref<GstBuffer>::adopt(gst_harness_try_pull(b.pictures.get()));
  ASSERT_TRUE(out);
  // 1, 1 to 2, 3 in the picture of 4 x 3; the longer side is 2, and 0.5 to 2.5 is rounded.
  const SourceMap map = gst::source_maps(out.get())[0];
  EXPECT_DOUBLE_EQ(map.to_source({0, 0}).x, 1);
  EXPECT_DOUBLE_EQ(map.to_source({2, 1}).x, 3);
}

// The box 1,1 to 3,2 turned clockwise by a quarter: the left edge of the tensor is its upper edge.
TEST(RegionsPad, RotatesAndEnlargesTheBoxesOfResults) {
  const std::string columns = results_caps("x1,y1,x2,y2,score,rotation", "6:1");
  const auto quarter = static_cast<float>(std::numbers::pi / 2);
  auto b =
      both("max-regions=1 clip-regions=false rotate-regions=true padding-value=9", columns.c_str());
  ASSERT_EQ(gst_harness_push(b.regions.get(), boxes<float>({1, 1, 3, 2, 1, quarter}, 0)),
            GST_FLOW_OK);
  ASSERT_EQ(gst_harness_push(b.pictures.get(), timed(frame(ramp(12)), 0)), GST_FLOW_OK);
  auto out = Ref<GstBuffer>::adopt(gst_harness_try_pull(b.pictures.get()));
  ASSERT_TRUE(out);
  // The means of 1, 2, 5, 6 and of 5, 6, 9, 10.
  EXPECT_EQ(values<uint8_t>(out.get()), (Bytes{4, 8}));
  const auto maps = gst::source_maps(out.get());
  ASSERT_EQ(maps.size(), 1u);
  EXPECT_EQ(maps[0].row, 1u);
  EXPECT_NEAR(maps[0].to_source({0, 0}).x, 2.5, 1e-6);
  EXPECT_NEAR(maps[0].to_source({0, 0}).y, 0.5, 1e-6);
  EXPECT_NEAR(maps[0].to_source({2, 1}).x, 1.5, 1e-6);
  EXPECT_NEAR(maps[0].to_source({2, 1}).y, 2.5, 1e-6);
  auto large = both(
      "max-regions=1 clip-regions=false square-regions=true region-scale=2 "
      "region-shift=0.5:-1",
      columns.c_str());
  ASSERT_EQ(gst_harness_push(large.regions.get(), boxes<float>({1, 1, 3, 2, 1, 0}, 0)),
            GST_FLOW_OK);
  ASSERT_EQ(gst_harness_push(large.pictures.get(), timed(frame(ramp(12)), 0)), GST_FLOW_OK);
  out = Ref<GstBuffer>::adopt(gst_harness_try_pull(large.pictures.get()));
  ASSERT_TRUE(out);
  // The centre 2, 1.5 moves to 3, 0.5; the sides are 4.
  const SourceMap map = gst::source_maps(out.get())[0];
  EXPECT_DOUBLE_EQ(map.to_source({0, 0}).x, 1);
  EXPECT_DOUBLE_EQ(map.to_source({2, 1}).x, 5);
}

TEST(RegionsPad, RejectsShapesThatHaveNoEffectOrMeaning) {
  EXPECT_SAYS(error_of_start("regions=pad rotate-regions=true"),
              "rotated regions cannot be clipped to the picture");
  EXPECT_SAYS(error_of_start("regions=pad rotate-regions=true"),
              "regions=pad rotate-regions=true clip-regions=false");
  EXPECT_SAYS(error_of_start("regions=meta rotate-regions=true clip-regions=false"),
              "the regions of metadata have no rotation");
  EXPECT_SAYS(error_of_start("region-scale=2"), "the shape of regions without regions");
  EXPECT_SAYS(error_of_start("regions=meta region-shift=1"), "X:Y, parts of the sides of a box");
  EXPECT_SAYS(error_of_start("regions=meta region-shift=1:b"), "region-shift");
}

TEST(RegionsPad, OfResultsWithoutObjectsMakesAGap) {
  auto b = both("max-regions=2", results_caps("x1,y1,x2,y2,score", "5:1").c_str());
  ASSERT_EQ(gst_harness_push(b.regions.get(), boxes<float>({0, 0, 0, 0, 0}, 0)), GST_FLOW_OK);
  ASSERT_EQ(gst_harness_push(b.pictures.get(), timed(frame(ramp(12)), 0)), GST_FLOW_OK);
  EXPECT_TRUE(pulled(b.pictures).empty());
  EXPECT_EQ(stat(b.pictures, "regions-empty"), 0u);
  EXPECT_EQ(stat(b.pictures, "dropped-policy"), 1u);
}

TEST(RegionsPad, SaysWhatResultsLack) {
  const auto error = [](const std::string& columns, const std::string& dimensions) {
    auto b = both("max-regions=2", kBoxes);
    Errors errors(b.pictures);
    gst_harness_set_src_caps_str(b.regions.get(), results_caps(columns, dimensions).c_str());
    return errors.next();
  };
  EXPECT_EQ(error("x1,y1,x2,y2,score", "5:1"), "");
  EXPECT_SAYS(error("x1,y1,x2,y2,score", "6:1"), "needed: float32 5:N, as weir-columns defines it");
  const std::string boxless = error("score,class", "2:1");
  EXPECT_SAYS(boxless, "the stream of regions has results without boxes");
  EXPECT_SAYS(boxless, "offered: weir-columns=\"score,class\"");
  EXPECT_SAYS(boxless, "fix: tensor_decoder mode=detection");
  EXPECT_SAYS(error("x1,y1,x2,score", "4:1"), "the columns of a stream of results cannot be read");
}

}  // namespace regions_pad_test
}  // namespace weir::preprocess_test
