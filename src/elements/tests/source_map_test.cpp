// Source maps through chains of elements.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/check/gstharness.h>
#include <gst/video/video.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "gstcpp/buffer/tensor_meta.hpp"
#include "gstcpp/element/ref.hpp"

namespace source_map_test {

using weir::SourceMap;
using weir::gst::Mapped;
using weir::gst::Ref;
using weir::gst::Unique;
using Harness = Unique<GstHarness, gst_harness_teardown>;

// The output for one picture of zeros.
Ref<GstBuffer> through(const std::string& elements, const std::string& format, int width,
                       int height, size_t bytes) {
  const Harness h{gst_harness_new_parse(elements.c_str())};
  gst_harness_set_src_caps_str(
      h.get(), ("video/x-raw,format=" + format + ",width=" + std::to_string(width) +
                ",height=" + std::to_string(height) + ",framerate=10/1,interlace-mode=progressive")
                   .c_str());
  GstBuffer* in = gst_buffer_new_allocate(nullptr, bytes, nullptr);
  gst_buffer_memset(in, 0, 0, bytes);
  GST_BUFFER_PTS(in) = 0;
  return Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
}

SourceMap only_map(GstBuffer* buffer) {
  const auto maps = weir::gst::source_maps(buffer);
  EXPECT_EQ(maps.size(), 1u);
  return maps.empty() ? SourceMap{} : maps[0];
}

TEST(SourceMap, StartsAtTheConverter) {
  const auto packed = only_map(through("tensor_converter", "RGB", 8, 6, 8 * 6 * 3).get());
  EXPECT_EQ(packed.source_width, 8u);
  EXPECT_EQ(packed.source_height, 6u);
  EXPECT_EQ(packed.x_dimension, 1);
  EXPECT_EQ(packed.y_dimension, 2);
  EXPECT_EQ(packed.to_source({3, 2}).x, 3);
  const auto planar = only_map(through("tensor_converter", "RGBP", 8, 6, 8 * 6 * 3).get());
  EXPECT_EQ(planar.x_dimension, 0);
  EXPECT_EQ(planar.y_dimension, 1);
}

TEST(SourceMap, FollowsTransformsWithAndWithoutCopies) {
  const auto map = only_map(
      through("tensor_converter ! tensor_transform mode=arithmetic option=add:1 ! "
              "tensor_transform mode=dimchg option=0:2 ! tensor_transform mode=padding "
              "option=left:4,top:2,bottom:1 ! tensor_transform mode=typecast option=float32",
              "RGB", 8, 6, 8 * 6 * 3)
          .get());
  EXPECT_EQ(map.x_dimension, 0);
  EXPECT_EQ(map.y_dimension, 1);
  EXPECT_EQ(map.width, 12u);
  EXPECT_EQ(map.height, 9u);
  EXPECT_EQ(map.to_source({4, 2}).x, 0);
  EXPECT_EQ(map.to_source({4, 2}).y, 0);
  EXPECT_EQ(map.to_tensor({8, 6}).x, 12);
}

// The output of mode=erring option1=to-source.
struct Reported {
  std::vector<SourceMap> maps;
  uint8_t of = 255;
};
Reported source_map_of_decoder(GstBuffer* buffer) {
  Reported out;
  const Mapped map(buffer, GST_MAP_READ);
  const auto bytes = map.as<const uint8_t>();
  if (bytes.empty()) return out;
  for (size_t at = 0; at + sizeof(weir_source_map) < bytes.size(); at += sizeof(weir_source_map)) {
    weir_source_map one;
    std::memcpy(&one, bytes.data() + at, sizeof one);
    out.maps.push_back(weir::source_map(one));
  }
  out.of = bytes.back();
  return out;
}

TEST(SourceMap, PassesThroughAFilterToADecoder) {
  const std::string model = testing::TempDir() + "weir-way-back.bin";
  std::ofstream(model) << "the engine ignores the frame";
  const auto out = through(
      "tensor_converter ! tensor_transform mode=dimchg option=0:2 ! tensor_transform mode=padding "
      "option=left:2,top:1 ! tensor_transform mode=typecast option=float32 ! tensor_filter "
      "framework=fake model=" +
          model + " ! tensor_decoder mode=erring option1=to-source",
      "GRAY8", 2, 3, 4 * 3);
  ASSERT_TRUE(out);
  const auto received = source_map_of_decoder(out.get());
  ASSERT_EQ(received.maps.size(), 1u);
  EXPECT_EQ(received.of, WEIR_MAPS_OF_TENSORS);
  const SourceMap& map = received.maps[0];
  EXPECT_EQ((std::vector{map.xx, map.xy, map.x0, map.yx, map.yy, map.y0}),
            (std::vector<double>{1, 0, -2, 0, 1, -1}));
  EXPECT_EQ(map.source_width, 2u);
  EXPECT_EQ(map.source_height, 3u);
}

TEST(SourceMap, InvertsLetterboxScaleAndCrop) {
  const Harness h{gst_harness_new_parse(
      "tensor_preprocess width=32 height=32 fit=letterbox layout=NCHW ! tensor_transform "
      "mode=padding option=left:3")};
  gst_harness_set_src_caps_str(h.get(),
                               "video/x-raw,format=GRAY8,width=640,height=360,framerate=10/1,"
                               "interlace-mode=progressive");
  for (const bool cropped : {false, true}) {
    GstBuffer* in = gst_buffer_new_allocate(nullptr, 640 * 360, nullptr);
    gst_buffer_memset(in, 0, 0, 640 * 360);
    if (cropped) {
      GstVideoCropMeta* crop = gst_buffer_add_video_crop_meta(in);
      crop->x = 100, crop->y = 50, crop->width = 128, crop->height = 128;
    }
    const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
    const auto map = only_map(out.get());
    EXPECT_EQ(map.source_width, 640u);
    // The whole: 32x18 in the middle of 32x32, a twentieth. The part: 32x32, a quarter.
    const weir::Point corner = map.to_source({3, cropped ? 0. : 7.});
    EXPECT_DOUBLE_EQ(corner.x, cropped ? 100 : 0);
    EXPECT_DOUBLE_EQ(corner.y, cropped ? 50 : 0);
    const weir::Point opposite = map.to_source({35, cropped ? 32. : 25.});
    EXPECT_DOUBLE_EQ(opposite.x, cropped ? 228 : 640);
    EXPECT_DOUBLE_EQ(opposite.y, cropped ? 178 : 360);
  }
}

TEST(SourceMap, IsNoneWithoutAPicture) {
  const Harness h{
      gst_harness_new_parse("tensor_converter input-dim=4 input-type=uint8 ! "
                            "tensor_decoder mode=erring option1=to-source")};
  gst_harness_set_src_caps_str(h.get(), "application/octet-stream,framerate=10/1");
  const auto out = Ref<GstBuffer>::adopt(
      gst_harness_push_and_pull(h.get(), gst_buffer_new_allocate(nullptr, 4, nullptr)));
  EXPECT_EQ(gst_buffer_get_size(out.get()), 1u);
  EXPECT_TRUE(weir::gst::source_maps(out.get()).empty());
}

TEST(SourceMap, OfSomeTensorsIsTheirOwn) {
  const Harness h{gst_harness_new_parse("tensor_transform mode=transpose option=1:0:2:3 apply=1")};
  gst_harness_set_src_caps_str(h.get(),
                               "other/tensors,format=static,num_tensors=2,"
                               "dimensions=(string)\"1:2:3,1:2:3\",types=(string)\"uint8,uint8\","
                               "framerate=30/1");
  GstBuffer* in = gst_buffer_new_allocate(nullptr, 6, nullptr);
  gst_buffer_append(in, gst_buffer_new_allocate(nullptr, 6, nullptr));
  weir::gst::set_source_maps(in, {weir::picture_as_it_is(2, 3, false)});
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  const auto maps = weir::gst::source_maps(out.get());
  ASSERT_EQ(maps.size(), 2u);
  EXPECT_EQ(maps[0].x_dimension, 1);
  EXPECT_EQ(maps[1].x_dimension, 0);
}

TEST(SourceMap, OfABatchOfRegionsHasOneForEach) {
  for (const char* apply : {"", " apply=0"}) {
    const Harness h{gst_harness_new_parse(
        (std::string("tensor_preprocess regions=meta max-regions=3 width=4 height=2 ! "
                     "tensor_transform mode=transpose option=2:1:0:3") +
         apply)
            .c_str())};
    gst_harness_set_src_caps_str(h.get(),
                                 "video/x-raw,format=RGB,width=8,height=8,framerate=10/1,"
                                 "interlace-mode=progressive");
    GstBuffer* in = gst_buffer_new_allocate(nullptr, 8 * 8 * 3, nullptr);
    gst_buffer_memset(in, 0, 0, 8 * 8 * 3);
    gst_buffer_add_video_region_of_interest_meta(in, "face", 0, 0, 8, 8);
    gst_buffer_add_video_region_of_interest_meta(in, "face", 3, 1, 4, 2);
    const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
    const auto maps = weir::gst::source_maps(out.get());
    ASSERT_EQ(maps.size(), 2u);
    for (const SourceMap& map : maps) {
      EXPECT_EQ(map.x_dimension, 1);
      EXPECT_EQ(map.y_dimension, 0);
    }
    EXPECT_EQ(maps[0].to_source({4, 2}).x, 8);
    EXPECT_EQ(maps[1].to_source({4, 2}).x, 7);
    EXPECT_EQ(maps[1].to_source({4, 2}).y, 3);
  }
}

TEST(SourceMap, OfAFlexibleBatchIsAdjustedForEachRegion) {
  for (const char* apply : {"", " apply=0"}) {
    const Harness h{
        gst_harness_new_parse((std::string("tensor_preprocess regions=meta width=4 height=2 ! "
                                           "tensor_transform mode=transpose option=2:1:0:3") +
                               apply)
                                  .c_str())};
    gst_harness_set_src_caps_str(h.get(),
                                 "video/x-raw,format=RGB,width=8,height=8,framerate=10/1,"
                                 "interlace-mode=progressive");
    GstBuffer* in = gst_buffer_new_allocate(nullptr, 8 * 8 * 3, nullptr);
    gst_buffer_memset(in, 0, 0, 8 * 8 * 3);
    for (guint i = 0; i < 3; ++i)
      gst_buffer_add_video_region_of_interest_meta(in, "face", i, i, 4, 2);
    ASSERT_EQ(gst_harness_push(h.get(), in), GST_FLOW_OK);
    const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    const auto maps = weir::gst::source_maps(out.get());
    ASSERT_EQ(maps.size(), 3u);
    EXPECT_EQ(weir::gst::maps_of(out.get()), weir::gst::MapsOf::Regions);
    for (size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(maps[i].x_dimension, 1);
      EXPECT_EQ(maps[i].y_dimension, 0);
      EXPECT_EQ(maps[i].to_source({0, 0}).x, static_cast<double>(i));
    }
  }
}

TEST(SourceMap, OfTensorsOfAFlexibleFrameIsTheirOwn) {
  const Harness h{gst_harness_new_parse(
      "tensor_converter ! other/tensors,format=flexible ! tensor_transform mode=transpose "
      "option=2:1:0:3 apply=0")};
  gst_harness_set_src_caps_str(h.get(),
                               "video/x-raw,format=RGB,width=4,height=2,framerate=10/1,"
                               "interlace-mode=progressive");
  ASSERT_EQ(gst_harness_push(h.get(), gst_buffer_new_allocate(nullptr, 24, nullptr)), GST_FLOW_OK);
  const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  EXPECT_EQ(only_map(out.get()).x_dimension, 1);
  EXPECT_EQ(only_map(out.get()).y_dimension, 0);
}

// Output of a decoder, and its maps, downstream of a filter for the second layer of a pyramid.
TEST(SourceMap, IsThatOfTheInputOfAFilter) {
  const std::string model = testing::TempDir() + "weir-way-back-layers.bin";
  std::ofstream(model) << "the engine ignores the frame";
  const std::string filter =
      "tensor_preprocess sizes=4x4,4x2 layout=NCHW channel-order=GRAY type=float32 ! "
      "tensor_filter framework=fake input-combination=1 model=" +
      model;
  const auto result = through(filter, "GRAY8", 8, 8, 64);
  EXPECT_EQ(only_map(result.get()).yy, 4);
  EXPECT_EQ(weir::gst::maps_of(result.get()), weir::gst::MapsOf::Tensors);
  const auto both = through(filter + " output-combination=i0,o0", "GRAY8", 8, 8, 64);
  const auto maps = weir::gst::source_maps(both.get());
  ASSERT_EQ(maps.size(), 2u);
  EXPECT_EQ(maps[0].yy, 2);
  EXPECT_EQ(maps[1].yy, 4);
  const auto decoded =
      through(filter + " ! tensor_decoder mode=erring option1=to-source", "GRAY8", 8, 8, 64);
  const auto received = source_map_of_decoder(decoded.get());
  ASSERT_EQ(received.maps.size(), 1u);
  EXPECT_EQ(received.maps[0].xx, 2);
  EXPECT_EQ(received.maps[0].yy, 4);
}

TEST(SourceMap, OfRegionsPassesThroughAFilter) {
  const std::string model = testing::TempDir() + "weir-way-back-regions.bin";
  std::ofstream(model) << "the engine ignores the frame";
  const Harness h{gst_harness_new_parse(
      ("tensor_preprocess regions=meta max-regions=2 width=4 height=1 channel-order=GRAY "
       "type=float32 ! tensor_transform mode=dimchg option=2:3 ! tensor_transform mode=dimchg "
       "option=0:2 ! "
       "tensor_filter framework=fake model=" +
       model)
          .c_str())};
  gst_harness_set_src_caps_str(h.get(),
                               "video/x-raw,format=GRAY8,width=8,height=8,framerate=10/1,"
                               "interlace-mode=progressive");
  GstBuffer* in = gst_buffer_new_allocate(nullptr, 64, nullptr);
  gst_buffer_memset(in, 0, 0, 64);
  for (guint i = 0; i < 2; ++i)
    gst_buffer_add_video_region_of_interest_meta(in, "face", i, i, 4, 2);
  ASSERT_EQ(gst_harness_push(h.get(), in), GST_FLOW_OK);
  const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  ASSERT_EQ(weir::gst::source_maps(out.get()).size(), 2u);
  EXPECT_EQ(weir::gst::maps_of(out.get()), weir::gst::MapsOf::Regions);
  EXPECT_EQ(weir::gst::source_maps(out.get())[1].to_source({0, 0}).x, 1);

  const Harness decoder{gst_harness_new_parse("tensor_decoder mode=erring option1=to-source")};
  const auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(h.get()->sinkpad));
  gst_harness_set_src_caps(decoder.get(), gst_caps_ref(caps.get()));
  const auto decoded =
      Ref<GstBuffer>::adopt(gst_harness_push_and_pull(decoder.get(), gst_buffer_ref(out.get())));
  const auto received = source_map_of_decoder(decoded.get());
  ASSERT_EQ(received.maps.size(), 2u);
  EXPECT_EQ(received.of, WEIR_MAPS_OF_REGIONS);
  EXPECT_EQ(received.maps[1].to_source({0, 0}).x, 1);
  EXPECT_EQ(received.maps[1].width, 4u);
}

TEST(SourceMap, IsReplacedCopiedAndRemoved) {
  const auto buffer = Ref<GstBuffer>::adopt(gst_buffer_new());
  weir::gst::set_source_maps(buffer.get(), {});
  EXPECT_TRUE(weir::gst::source_maps(buffer.get()).empty());
  weir::gst::set_source_maps(buffer.get(), {weir::picture_as_it_is(2, 3, false)});
  weir::gst::set_source_maps(buffer.get(), {weir::picture_as_it_is(4, 5, true), SourceMap{}},
                             weir::gst::MapsOf::Regions);
  ASSERT_EQ(weir::gst::source_maps(buffer.get()).size(), 2u);
  const auto copy = Ref<GstBuffer>::adopt(gst_buffer_copy_deep(buffer.get()));
  weir::gst::set_source_maps(buffer.get(), {});
  EXPECT_TRUE(weir::gst::source_maps(buffer.get()).empty());
  ASSERT_EQ(weir::gst::source_maps(copy.get()).size(), 2u);
  EXPECT_EQ(weir::gst::source_maps(copy.get())[0].source_width, 4u);
  EXPECT_EQ(weir::gst::maps_of(copy.get()), weir::gst::MapsOf::Regions);
  EXPECT_EQ(weir::gst::maps_of(buffer.get()), weir::gst::MapsOf::Tensors);
}

}  // namespace source_map_test
