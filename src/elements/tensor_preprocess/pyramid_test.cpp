// Several output sizes of each frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_preprocess/preprocess_test_support.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir::preprocess_test {
namespace pyramid_test {

std::vector<Bytes> memories(GstBuffer* buffer) {
  std::vector<Bytes> out;
  for (guint i = 0; i < gst_buffer_n_memory(buffer); ++i) {
    const gst::MappedMemory map(gst_buffer_peek_memory(buffer, i), GST_MAP_READ);
    const auto* data = reinterpret_cast<const uint8_t*>(map.bytes().data());
    out.emplace_back(data, data + map.bytes().size());
  }
  return out;
}

TEST(Pyramid, EachLayerEqualsASeparateConversion) {
  for (const std::string format : {"RGB", "NV12", "I420", "YUY2"})
    for (const std::string more :
         {" method=area", " fit=letterbox mean=3 layout=NCHW", " threads=3 method=nearest"}) {
      const auto caps = video(format, 64, 36);
      auto h = harness("sizes=40x30,20x15,7x5,64x36,1x1" + more, caps);
      for (const bool cropped : {false, true}) {
        const auto picture = [&] {
          GstBuffer* in = frame(ramp(frame_bytes(format, 64, 36)));
          if (cropped) crop(in, 5, 7, 31, 13);
          return in;
        };
        const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), picture()));
        ASSERT_TRUE(out);
        const auto layers = memories(out.get());
        const auto maps = gst::source_maps(out.get());
        ASSERT_EQ(layers.size(), 5u);
        ASSERT_EQ(maps.size(), 5u);
        const char* singles[] = {"width=40 height=30", "width=20 height=15", "width=7 height=5",
                                 "width=64 height=36", "width=1 height=1"};
        for (size_t i = 0; i < 5; ++i) {
          auto single = harness(singles[i] + more, caps);
          EXPECT_EQ(layers[i], pushed<uint8_t>(single, picture())) << format << more << i;
        }
      }
      EXPECT_EQ(stat(h, "pool-allocated"), 1u);
    }
}

TEST(Pyramid, CapsAndMapsDescribeEachLayer) {
  auto h = harness("sizes=32x18,16x16 layout=NHWC fit=letterbox", video("GRAY8", 64, 36));
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(ramp(64 * 36))));
  EXPECT_SAYS(caps_text(h), "num_tensors=(int)2");
  EXPECT_SAYS(caps_text(h), "3:32:18:1\\,3:16:16:1");
  const auto maps = gst::source_maps(out.get());
  ASSERT_EQ(maps.size(), 2u);
  EXPECT_EQ(maps[0].to_source({32, 18}).x, 64);
  EXPECT_EQ(maps[0].to_source({32, 18}).y, 36);
  // 16x9 in the middle of 16x16: three rows above, a quarter of the size.
  EXPECT_EQ(maps[1].to_source({16, 3}).x, 64);
  EXPECT_EQ(maps[1].to_source({16, 3}).y, 0);
  EXPECT_EQ(maps[1].to_source({0, 12}).y, 36);
}

TEST(Pyramid, TakesTypesFromDownstream) {
  Harness h{gst_harness_new_parse("tensor_preprocess sizes=4x3,2x1")};
  gst_harness_set_sink_caps_str(h.get(),
                                "other/tensors,format=static,num_tensors=2,dimensions=(string)\"4:"
                                "3:3:1,2:1:3:1\",types=(string)\"float32,uint8\",framerate=10/1");
  gst_harness_set_src_caps_str(h.get(), video("RGB", 8, 6).c_str());
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(ramp(144))));
  ASSERT_TRUE(out);
  const auto layers = memories(out.get());
  ASSERT_EQ(layers.size(), 2u);
  EXPECT_EQ(layers[0].size(), 4u * 4 * 3 * 3);
  EXPECT_EQ(layers[1].size(), 2u * 1 * 3);
}

TEST(Pyramid, HasAtMostSixteenLayers) {
  std::string sizes = "sizes=16x16";
  for (int i = 15; i > 0; --i) sizes += "," + std::to_string(i) + "x" + std::to_string(i);
  auto h = harness(sizes, video("GRAY8", 40, 30));
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(ramp(1200))));
  ASSERT_TRUE(out);
  EXPECT_EQ(gst_buffer_n_memory(out.get()), 16u);
  EXPECT_SAYS(error_of_start(sizes + ",1x1"), "offered: sizes of 17 layers");
}

TEST(Pyramid, RejectsUnreadableSizes) {
  const auto text = error_of_start("sizes=640x480,320y240");
  EXPECT_SAYS(text, "WEIR-1001: sizes cannot be read");
  EXPECT_SAYS(text, "at character 9");
  EXPECT_SAYS(text, "640x480,320y240\n");
  EXPECT_SAYS(text, "sizes=640x640,320x320,160x160");
}

TEST(Pyramid, ExcludesWidthAndHeight) {
  const auto text = error_of_start("sizes=8x8 height=4");
  EXPECT_SAYS(text, "WEIR-1004");
  EXPECT_SAYS(text, "offered: width=0 height=4 sizes=8x8");
}

TEST(Pyramid, ReportsTheFirstLayerThatDoesNotFit) {
  const auto text = error_with_caps(
      "sizes=4x3,2x1", video("RGB", 8, 6),
      "other/tensors,format=static,num_tensors=2,dimensions=(string)\"3:4:3:1,3:2:2:1\","
      "types=(string)\"uint8,uint8\",framerate=10/1");
  EXPECT_SAYS(text, "the element downstream of tensor_preprocess needs another tensor");
  EXPECT_SAYS(text, "3:2:2:1");
}

}  // namespace pyramid_test
}  // namespace weir::preprocess_test
