// The mode bounding_boxes in the element: caps, static and flexible streams, properties in any
// order and while playing, and errors on the bus.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>
#include <fstream>

#include "elements/tensor_decoder/decoder_test_support.hpp"
#include "elements/tests/flexible_frame_test_support.hpp"
#include "elements/tests/tuning_test_support.hpp"

namespace weir::testing_tensor_decoder {
namespace bounding_boxes_test {

const std::string kCaps =
    "other/tensor,dimension=(string)6:2,type=(string)float32,framerate=(fraction)30/1";
const std::string kMode = "mode=bounding_boxes option1=yolov10 option4=8:8 option5=8:8";
// x1, y1, x2, y2, score, class; the second row is below the threshold.
const std::vector<float> kRows{0.25f, 0.25f, 0.75f, 0.75f, 0.5f, 0, 0, 0, 1, 1, 0.125f, 0};

// The red pixels of an RGBA frame of 8 x 8, a row of text for each.
std::string red(const Bytes& pixels) {
  std::string text;
  for (size_t at = 0; at + 4 <= pixels.size(); at += 4)
    text += pixels[at] == 255 && pixels[at + 3] == 255 ? '#' : '.';
  return text;
}
const std::string kDrawn =
    "........"
    "........"
    "..#####."
    "..#...#."
    "..#...#."
    "..#...#."
    "..#####."
    "........";

TEST(BoundingBoxes, DrawsOnATransparentFrame) {
  auto h = harness(kMode, kCaps);
  EXPECT_EQ(red(decoded(h, frame(kRows))), kDrawn);
  EXPECT_SAYS(caps_text(h), "video/x-raw");
  EXPECT_SAYS(caps_text(h), "format=(string)RGBA");
  EXPECT_SAYS(caps_text(h), "width=(int)8, height=(int)8");
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)30/1");
  EXPECT_EQ(stat(h, "consumed"), 1u);
}

TEST(BoundingBoxes, PropertiesMayHaveAnyOrder) {
  auto h =
      harness("option5=8:8 option3=0:0.25 option1=yolov10 option4=8:8 mode=bounding_boxes", kCaps);
  EXPECT_EQ(red(decoded(h, frame(kRows))), kDrawn);
}

TEST(BoundingBoxes, TheOldModeNameMeansTheSame) {
  auto h = harness("mode=bounding_box option1=yolov10 option4=8:8 option5=8:8", kCaps);
  EXPECT_EQ(red(decoded(h, frame(kRows))), kDrawn);
}

TEST(BoundingBoxes, AnotherSizeWhilePlayingActsOnTheNextFrame) {
  Tuned t("tensor_decoder", "tensor_decoder " + kMode, kCaps);
  Bytes bytes(kRows.size() * sizeof(float));
  std::memcpy(bytes.data(), kRows.data(), bytes.size());
  EXPECT_EQ(red(t.push<>(bytes)), kDrawn);
  t.set("option4", "16:4");
  EXPECT_EQ(t.push<>(bytes).size(), 16u * 4 * 4);
  EXPECT_SAYS(t.caps(), "width=(int)16, height=(int)4");
  t.set("option4", "16x4");
  EXPECT_EQ(t.push<>(bytes).size(), 16u * 4 * 4);
  EXPECT_SAYS(t.messages.next_warning(), "WEIR-1001: option4 is not a size");
  EXPECT_EQ(t.get("option4"), "16:4");
}

TEST(BoundingBoxes, ErrorsAreOnTheBus) {
  EXPECT_SAYS(get_error("mode=bounding_boxes option1=yolo10 option4=8:8 option5=8:8"),
              "did you mean yolov10?");
  EXPECT_SAYS(get_error("mode=bounding_boxes option1=yolov10 option4=8:8"), "option5 is required");
  EXPECT_SAYS(get_error(kMode + " option2=/nowhere/labels.txt"), "WEIR-4001");
  EXPECT_SAYS(get_error(kMode, tensor("float32", "5:2"), Bytes(40)),
              "WEIR-2001: option1=yolov10 does not accept these tensors");
  EXPECT_SAYS(get_error(kMode, tensor("uint8", "6:2"), Bytes(12)),
              "fix: tensor_transform mode=typecast option=float32");
  EXPECT_SAYS(get_error("mode=bounding_box option1=mobilenet-ssd option4=8:8 option5=8:8 "
                        "option3=/nowhere/priors.txt"),
              "No such file or directory");
}

TEST(BoundingBoxes, AFrameLargerThanTheLimitIsAnError) {
  EXPECT_SAYS(get_error("mode=bounding_boxes option1=yolov10 option4=32767:32767 option5=8:8 "
                        "max-buffer-size=1000000",
                        tensor("float32", "6:2"), Bytes(48)),
              "WEIR-2006");
}

// Each frame of a flexible stream has its own shape.
TEST(BoundingBoxes, DecodesFlexibleStreams) {
  auto h = harness(kMode, kFlexibleCaps);
  for (const uint32_t rows : {1u, 2u}) {
    const std::vector<float> values(kRows.begin(), kRows.begin() + 6 * rows);
    GstBuffer* in = flexible_frame({ElementType::Float32, Shape{6, rows}, ""}, values);
    const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
    EXPECT_EQ(red(content(out.get())), kDrawn) << rows;
  }
}

TEST(BoundingBoxes, AFlushBeginsTheNumbersAgain) {
  const std::string labels = testing::TempDir() + "weir-bounding-boxes.txt";
  std::ofstream(labels) << "#\n";
  const std::string line =
      "mode=bounding_boxes option1=yolov10 option4=64:64 option5=64:64 option6=1 option2=" + labels;
  const std::vector<float> two{0.5f, 0.25f, 0.75f, 0.5f, 0.5f, 0, 0, 0.75f, 0.25f, 0.9f, 0.5f, 0};
  const std::vector<float> second{0, 0.75f, 0.25f, 0.9f, 0.5f, 0, 0, 0, 1, 1, 0.125f, 0};
  auto h = harness(line, kCaps), fresh = harness(line, kCaps);
  const std::string number_one = red(decoded(fresh, frame(second)));
  decoded(h, frame(two));
  EXPECT_NE(red(decoded(h, frame(second))), number_one) << "it is number 2";
  gst_harness_push_event(h.get(), gst_event_new_flush_start());
  gst_harness_push_event(h.get(), gst_event_new_flush_stop(TRUE));
  gst_harness_push_event(h.get(), time_segment());
  EXPECT_EQ(red(decoded(h, frame(second))), number_one);
}

}  // namespace bounding_boxes_test
}  // namespace weir::testing_tensor_decoder
