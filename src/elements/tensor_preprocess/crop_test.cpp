// The property crop: the part of the picture that is used, changing from frame to frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_preprocess/preprocess_test_support.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir::preprocess_test {
namespace crop_test {

constexpr const char* kGray = "channel-order=GRAY type=uint8 ";

void set_crop(const Harness& h, const char* text) {
  const auto e = Ref<GstElement>::adopt(gst_harness_find_element(h.get(), "tensor_preprocess"));
  g_object_set(e.get(), "crop", text, nullptr);
}

TEST(Crop, IsThePartThatTheTensorIsMadeOf) {
  auto h = harness(std::string(kGray) + "width=2 height=1 crop=1:2:2:1", video("GRAY8", 4, 3));
  EXPECT_EQ(pushed<uint8_t>(h, frame(ramp(12))), (Bytes{9, 10}));
}

TEST(Crop, ChangesFromFrameToFrame) {
  for (const char* more : {"", "threads=2 ", "sizes=2x1,1x1 "}) {
    const bool pyramid = more[0] == 's';
    auto h = harness(std::string(kGray) + more + (pyramid ? "" : "width=2 height=1"),
                     video("GRAY8", 4, 3));
    const auto first_two = [&] {
      auto out = pushed<uint8_t>(h, frame(ramp(12)));
      out.resize(2);
      return out;
    };
    set_crop(h, "0:1:2:1");
    EXPECT_EQ(first_two(), (Bytes{4, 5}));
    set_crop(h, "2:2:2:1");
    EXPECT_EQ(first_two(), (Bytes{10, 11}));
    EXPECT_EQ(first_two(), (Bytes{10, 11}));
    set_crop(h, "0:0:2:3");
    EXPECT_EQ(first_two(), (Bytes{4, 5}));
    set_crop(h, "");                                          // the whole picture: 4x3 to 2x1
    EXPECT_EQ(first_two(), (Bytes{4, 6}));                    // 4.5 and 6.5, rounded half to even
    EXPECT_EQ(stat(h, "pool-allocated"), pyramid ? 5u : 1u);  // pushed() merges several memories
  }
}

TEST(Crop, IsPartOfTheSourceMap) {
  auto h = harness("width=4 height=4 fit=letterbox crop=10:20:40:20", video("GRAY8", 64, 48));
  ASSERT_EQ(gst_harness_push(h.get(), frame(ramp(64 * 48))), GST_FLOW_OK);
  const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  const auto maps = gst::source_maps(out.get());
  ASSERT_EQ(maps.size(), 1u);
  EXPECT_DOUBLE_EQ(maps[0].to_source({0, 1}).x, 10);
  EXPECT_DOUBLE_EQ(maps[0].to_source({0, 1}).y, 20);
  EXPECT_DOUBLE_EQ(maps[0].to_source({4, 3}).x, 50);
  EXPECT_DOUBLE_EQ(maps[0].to_source({4, 3}).y, 40);
}

TEST(Crop, IsWithinTheCropOfABuffer) {
  auto h = harness(std::string(kGray) + "width=1 height=1 crop=1:1:1:1", video("GRAY8", 4, 3));
  GstBuffer* in = frame(ramp(12));
  crop(in, 1, 1, 3, 2);
  EXPECT_EQ(pushed<uint8_t>(h, in), (Bytes{10}));
  EXPECT_EQ(pushed<uint8_t>(h, frame(ramp(12))), (Bytes{5}));
}

TEST(Crop, ClipsRegions) {
  auto h = harness(std::string(kGray) + "regions=meta max-regions=2 width=2 height=1 crop=1:1:2:1",
                   video("GRAY8", 4, 3));
  GstBuffer* in = frame(ramp(12));
  gst_buffer_add_video_region_of_interest_meta(in, "face", 0, 0, 4, 3);
  gst_buffer_add_video_region_of_interest_meta(in, "face", 0, 0, 4, 1);
  EXPECT_EQ(pushed<uint8_t>(h, in), (Bytes{5, 6, 0, 0}));
  EXPECT_EQ(stat(h, "regions-empty"), 1u);
}

TEST(Crop, OutsideThePictureIsRejected) {
  for (const char* outside : {"3:0:2:1", "0:3:1:1", "0:0:65536:1"}) {
    auto h = harness("width=2 height=1", video("GRAY8", 4, 3));
    EXPECT_FALSE(pushed<uint8_t>(h, frame(ramp(12))).empty());
    set_crop(h, outside);
    const auto text = get_error(
        h, [&] { EXPECT_EQ(gst_harness_push(h.get(), frame(ramp(12))), GST_FLOW_ERROR); });
    EXPECT_SAYS(text, "the crop exceeds the picture");
    EXPECT_SAYS(text, "needed: a part of 4x3");
    EXPECT_EQ(stat(h, "dropped-error"), 1u);
  }
}

TEST(Crop, ThatIsUnreadableIsReportedWithItsPosition) {
  EXPECT_SAYS(error_of_start("width=2 height=1 crop=1:2:3"), "needed: X:Y:WIDTH:HEIGHT");
  auto h = harness("width=2 height=1", video("GRAY8", 4, 3));
  set_crop(h, "1:2:0:3");
  const auto text =
      get_error(h, [&] { EXPECT_EQ(gst_harness_push(h.get(), frame(ramp(12))), GST_FLOW_ERROR); });
  EXPECT_SAYS(text, "crop cannot be read");
  EXPECT_SAYS(text, "at character 5:\n    1:2:0:3\n        ^");
}

}  // namespace crop_test
}  // namespace weir::preprocess_test
