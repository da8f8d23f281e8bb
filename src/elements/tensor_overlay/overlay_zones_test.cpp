// Tests of zones and trails that come with a stream of results.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>

#include "core/records/zone_columns.hpp"
#include "core/tensor/tensor_header.hpp"
#include "elements/tensor_overlay/overlay_test_support.hpp"
#include "gstcpp/element/result_events.hpp"

namespace weir::overlay_test {
namespace overlay_zones_test {

constexpr int kSide = 40;
constexpr char kZones[] =
    R"({"version":1,"zones":[{"name":"a","polygon":[[10,10],[30,10],[30,30],[10,30]]}]})";

GstMemory* table(uint32_t length, const std::vector<float>& numbers) {
  TensorHeader header;
  header.spec = {.type = ElementType::Float32,
                 .shape = Shape{length, static_cast<uint32_t>(numbers.size() / length)},
                 .name = {}};
  header.format = Format::Flexible;
  auto* memory =
      gst_allocator_alloc(nullptr, kTensorHeaderBytes + numbers.size() * sizeof(float), nullptr);
  const gst::MappedMemory map(memory, GST_MAP_WRITE);
  write_tensor_header(header, map.bytes().first<kTensorHeaderBytes>());
  std::memcpy(map.bytes().data() + kTensorHeaderBytes, numbers.data(),
              numbers.size() * sizeof(float));
  return memory;
}

// An overlay whose results come with zones.
struct Zoned {
  Ref<GstElement> element;
  Harness results, pictures;

  explicit Zoned(const std::string& properties)
      : element(lone_element("tensor_overlay show-scores=false auto-size=false line-width=1 " +
                             properties)),
        results{gst_harness_new_with_element(element.get(), "results", nullptr)},
        pictures{gst_harness_new_with_element(element.get(), "sink", "src")} {
    const std::string caps = std::string("other/tensors,format=flexible,framerate=10/1,") +
                             "weir-columns=(string)\"x1,y1,x2,y2,track;" +
                             records::kZoneCountColumns + ";" + records::kZoneEventColumns +
                             "\",weir-source=(string)\"yolo;zones;zones\"";
    gst_harness_set_src_caps_str(results.get(), caps.c_str());
    gst_harness_set_src_caps_str(pictures.get(), video("GRAY8", kSide, kSide).c_str());
  }
  void send_zones(const gst::ZonesOfSource& zones) const {
    gst_harness_push_event(results.get(), gst::make_zones_event(zones).release());
  }
  // The picture with a box whose lower edge has its middle at x, 38.
  Bytes picture(float x, GstClockTime time) const {
    GstBuffer* in = gst_buffer_new();
    gst_buffer_append_memory(in, table(5, {x - 2, 35, x + 2, 38, 7}));
    gst_buffer_append_memory(in, table(10, std::vector<float>(10)));
    gst_buffer_append_memory(in, table(8, std::vector<float>(8)));
    GST_BUFFER_PTS(in) = time;
    gst_harness_push(results.get(), in);
    return repeated(time);
  }
  Bytes repeated(GstClockTime time) const {
    const auto out = Ref<GstBuffer>::adopt(
        gst_harness_push_and_pull(pictures.get(), frame(Bytes(kSide * kSide), time)));
    return out ? content(out.get()) : Bytes();
  }
};
bool is_painted(const Bytes& picture, size_t x, size_t y) {
  return picture.at(y * kSide + x) != 0;
}

TEST(OverlayZones, AreThoseOfTheStream) {
  const Zoned z("");
  EXPECT_FALSE(is_painted(z.picture(20, 0), 20, 9)) << "no zones yet";
  z.send_zones({"other", kZones});
  EXPECT_FALSE(is_painted(z.picture(20, 1), 20, 9)) << "zones of another source";
  z.send_zones({"zones", kZones});
  const auto with = z.picture(20, 2);
  EXPECT_TRUE(is_painted(with, 20, 9));
  EXPECT_TRUE(is_painted(with, 20, 29));
  EXPECT_FALSE(is_painted(with, 20, 20));
  z.send_zones({"zones", R"({"version":1,"zones":[]})"});
  EXPECT_FALSE(is_painted(z.picture(20, 3), 20, 9)) << "taken back";
}

TEST(OverlayZones, ThatCannotBeUsedAreNotDrawn) {
  const Zoned z("");
  Errors errors(z.element.get());
  z.send_zones({"zones", R"({"version":1,"zones":[{"name":"a","polygon":[[1,1]]}]})"});
  EXPECT_FALSE(is_painted(z.picture(20, 0), 20, 9));
  EXPECT_EQ(errors.next(), "");
}

TEST(OverlayZones, CanBeSwitchedOffWhilePlaying) {
  const Zoned z("show-zones=false");
  z.send_zones({"zones", kZones});
  EXPECT_FALSE(is_painted(z.picture(20, 0), 20, 9));
  g_object_set(z.element.get(), "show-zones", TRUE, nullptr);
  EXPECT_TRUE(is_painted(z.picture(20, 1), 20, 9));
}

TEST(OverlayTrails, FollowATrackAndEndWithAFlush) {
  const Zoned z("trail-length=3");
  z.picture(4, 0);
  EXPECT_TRUE(is_painted(z.picture(30, 1), 15, 37));
  for (GstClockTime time = 2; time < 8; ++time)
    EXPECT_TRUE(is_painted(z.repeated(time), 15, 37)) << "the same results are no further step";
  z.picture(31, 8);
  EXPECT_FALSE(is_painted(z.picture(32, 9), 15, 37)) << "the trail has moved on";
  z.picture(4, 10);
  gst_harness_push_event(z.pictures.get(), gst_event_new_flush_start());
  gst_harness_push_event(z.pictures.get(), gst_event_new_flush_stop(TRUE));
  gst_harness_push_event(z.pictures.get(), time_segment());
  EXPECT_FALSE(is_painted(z.picture(32, 11), 15, 37)) << "no line from before the flush";
}

TEST(OverlayTrails, AreOffUnlessTheirLengthIsSet) {
  const Zoned z("");
  z.picture(4, 0);
  EXPECT_FALSE(is_painted(z.picture(30, 1), 15, 37));
}

TEST(OverlayColors, AreThoseOfTracksIfAskedFor) {
  const Zoned by_class("color-by=class"), by_track("color-by=track");
  const size_t at = 35 * kSide + 20;
  const auto gray = [](draw::Rgb c) {
    preprocess::Picture picture;
    picture.format = *preprocess::picture_format("GRAY8");
    return draw::to_samples(picture, c)[0];
  };
  const auto class_gray = gray(draw::class_color(0)), track_gray = gray(draw::class_color(7));
  ASSERT_NE(class_gray, track_gray);
  EXPECT_NEAR(by_class.picture(20, 0).at(at), class_gray, 20);
  EXPECT_NE(by_track.picture(20, 0).at(at), by_class.picture(20, 1).at(at));
}

}  // namespace overlay_zones_test
}  // namespace weir::overlay_test
