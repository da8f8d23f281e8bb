// tensor_decoder with the built-in modes that make pictures and regions; each has its own tests.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>
#include <cstring>
#include <fstream>

#include "elements/tensor_decoder/decoder_test_support.hpp"

namespace weir::testing_tensor_decoder {
namespace drawing_test {

std::string file_with(const char* name, const std::string& text) {
  const std::string path = testing::TempDir() + name;
  std::ofstream(path, std::ios::binary) << text;
  return path;
}
std::string two_tensors(const char* first, const char* second) {
  return std::string("other/tensors,format=static,num_tensors=2,dimensions=(string)\"") + first +
         "," + second + "\",types=(string)\"float32,float32\",framerate=30/1";
}
GstBuffer* make_frame(const std::vector<float>& first, const std::vector<float>& second) {
  GstBuffer* out = frame(first);
  const auto other = Ref<GstBuffer>::adopt(frame(second));
  gst_buffer_append_memory(out, gst_memory_ref(gst_buffer_peek_memory(other.get(), 0)));
  return out;
}
Bytes to_bytes(const std::vector<float>& values) {
  Bytes out(values.size() * sizeof(float));
  std::memcpy(out.data(), values.data(), out.size());
  return out;
}

TEST(TensorDecoderDrawing, PaintsClasses) {
  auto h = harness("option2=2 option1=tflite-deeplab mode=image_segment",  // in any order
                   tensor("float32", "3:2:1"));
  EXPECT_EQ(decoded(h, frame(std::vector<float>{0, 1, 2, /**/ 3, 2, 1})),
            (Bytes{0xAA, 0xAA, 0xAA, 0xFF, 0, 0, 0, 0}));
  EXPECT_SAYS(caps_text(h), "video/x-raw, format=(string)RGBA, width=(int)2, height=(int)1");
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)30/1");
  EXPECT_EQ(stat(h, "consumed"), 1u);
}

TEST(TensorDecoderDrawing, PaintsDepths) {
  auto h = harness("mode=image_segment option1=snpe-depth", tensor("float32", "1:2:1"));
  EXPECT_EQ(decoded(h, frame(std::vector<float>{1, 2})),
            (Bytes{0x7F, 0x7F, 0x7F, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}));
}

TEST(TensorDecoderDrawing, FollowsCapsOfAnotherSize) {
  auto h = harness("mode=image_segment option1=snpe-deeplab", tensor("float32", "2:1"));
  EXPECT_EQ(decoded(h, frame(std::vector<float>{0, 0})).size(), 8u);
  gst_harness_set_src_caps_str(h.get(), tensor("float32", "3:2").c_str());
  EXPECT_EQ(decoded(h, frame(std::vector<float>(6))).size(), 24u);
  EXPECT_SAYS(caps_text(h), "width=(int)3, height=(int)2");
}

TEST(TensorDecoderDrawing, ReportsPixelsWithoutAClass) {
  const std::string message = get_error("mode=image_segment option1=snpe-deeplab option2=3",
                                        tensor("float32", "2:1"), to_bytes({1, NAN}));
  EXPECT_SAYS(message, "WEIR-2001: a pixel has a number that is not a class");
  EXPECT_SAYS(message, "nan at pixel 1, 0");
}

TEST(TensorDecoderDrawing, ReportsOptionsThatCannotBeUsed) {
  EXPECT_SAYS(get_error("mode=image_segment option1=deeplab"),
              "WEIR-1004: option1 is not a kind of segmentation");
  EXPECT_SAYS(get_error("mode=pose_estimation option1=0:0 option2=2:2"),
              "WEIR-1004: option1 is a size that cannot be used");
  EXPECT_SAYS(get_error("mode=pose_estimatio option1=2:2 option2=2:2"),
              "did you mean pose_estimation?");
  EXPECT_SAYS(get_error("mode=tensor_region option2=/nowhere/labels.txt"),
              "No such file or directory");
}

TEST(TensorDecoderDrawing, DrawsKeyPoints) {
  const std::string body = file_with("weir-body.txt", "a 1\nb\n");
  auto h = harness("mode=pose_estimation option1=60:40 option2=3:2 option3=" + body,
                   tensor("float32", "2:3:2"));
  // Key point 0 in cell 0, 1 and key point 1 in cell 2, 1: a line in row 20 from 0 to 40.
  const Bytes pixels = decoded(h, frame(std::vector<float>{0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}));
  ASSERT_EQ(pixels.size(), 4u * 60 * 40);
  for (size_t x = 0; x < 60; ++x)
    EXPECT_EQ(pixels[4 * (20 * 60 + x)], x <= 44 ? 255 : 0) << x;  // with the dot at its end
  EXPECT_SAYS(caps_text(h), "format=(string)RGBA, width=(int)60, height=(int)40");
}

TEST(TensorDecoderDrawing, DrawsKeyPointsWithOffsets) {
  const std::string body = file_with("weir-body.txt", "a 1\nb\n");
  auto h = harness(
      "mode=pose_estimation option4=heatmap-offset option1=20:20 option2=10:10 "
      "option3=" +
          body,
      two_tensors("2:2:2", "4:2:2"));
  std::vector<float> offsets(16);
  offsets[1] = 5;  // y of key point 1 in cell 0, 0
  const auto out = Ref<GstBuffer>::adopt(
      gst_harness_push_and_pull(h.get(), make_frame({9, 9, -9, -9, -9, -9, -9, -9}, offsets)));
  const Bytes pixels = content(out.get());
  ASSERT_EQ(pixels.size(), 1600u);
  EXPECT_EQ(pixels[4 * (13 * 20)], 255) << "rows below the name of the first point";
  EXPECT_EQ(pixels[4 * (14 * 20)], 255) << "the dot of the second";
  EXPECT_EQ(pixels[4 * (15 * 20)], 0) << "ends there";
}

TEST(TensorDecoderDrawing, ReportsAnotherNumberOfKeyPoints) {
  const std::string message = get_error("mode=pose_estimation option1=6:4 option2=2:2",
                                        tensor("float32", "17:2:2"), Bytes(4 * 68));
  EXPECT_SAYS(message,
              "WEIR-2001: the heat map has a different number of key points than the body");
  EXPECT_SAYS(message, "offered: float32 17:2:2");
}

TEST(TensorDecoderDrawing, WritesRegionsThatTensorCropCuts) {
  const std::string labels = file_with("weir-region-labels.txt", "background\nface\n");
  const std::string priors = file_with("weir-region-priors.txt", "0.5\n0.25\n0.5\n0.5\n");
  auto h = harness(
      "mode=tensor_region option1=2 option2=" + labels + " option3=" + priors + " option4=8:4",
      two_tensors("4:1:1", "2:1"));
  const auto out =
      Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), make_frame({0, 0, 0, 0}, {0, 3})));
  EXPECT_SAYS(caps_text(h), "other/tensors, format=(string)flexible, framerate=(fraction)30/1");
  const Bytes info = content(out.get());
  ASSERT_EQ(info.size(), 128u + 32);
  EXPECT_EQ(Bytes(info.begin() + 128, info.end()),
            (Bytes{0, 0, 0, 0, 1, 0, 0, 0, 4, 0, 0, 0, 2, 0, 0, 0,  //
                   0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
}

}  // namespace drawing_test
}  // namespace weir::testing_tensor_decoder
