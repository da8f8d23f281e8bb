// Pictures of odd, tiny and huge sizes, and metadata with invalid row positions.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/bad_input_bench_test_support.hpp"

namespace bad_video_test {

using namespace weir::testing_bad_input;

struct Rows {
  const char* name;
  std::vector<gint> strides;
  std::vector<gsize> offsets;
  guint width = 8, height = 4;
  const char *converter, *preprocess;  // the error text; "" = accepted
  GstVideoFormat format = GST_VIDEO_FORMAT_RGB;
};
void PrintTo(const Rows& rows, std::ostream* out) {
  *out << rows.name;
}

class InvalidRows : public testing::TestWithParam<Rows> {};

// 96 bytes of 8x4 RGB, 24 a row.
TEST_P(InvalidRows, AreReportedBeforeTheyAreRead) {
  const Rows& rows = GetParam();
  for (const auto& subject : subjects()) {
    const std::string name = subject.name;
    if (name != "converter" && name != "preprocess") continue;
    Bench bench(subject);
    ASSERT_EQ(bench.start(subject.caps), "");
    GstBuffer* in = zeros(96);
    auto offsets = rows.offsets;
    auto strides = rows.strides;
    gst_buffer_add_video_meta_full(in, GST_VIDEO_FRAME_FLAG_NONE, rows.format, rows.width,
                                   rows.height, static_cast<guint>(offsets.size()), offsets.data(),
                                   strides.data());
    const std::string error = bench.push(in);
    const std::string message = name == "converter" ? rows.converter : rows.preprocess;
    EXPECT_EQ(error.empty(), message.empty()) << name << ": " << error;
    EXPECT_SAYS(error, message) << name;
    expect_sound_again(bench, subject, 1);
  }
}
constexpr const char* kRows = "WEIR-2004: a picture is shorter than its size requires";
constexpr const char* kShort = "WEIR-2004: a video buffer is smaller than its caps require";
constexpr const char* kOther = "WEIR-2002: the video metadata of a buffer does not match";
INSTANTIATE_TEST_SUITE_P(
    All, InvalidRows,
    testing::Values(
        Rows{"true", {24}, {0}, 8, 4, "", ""}, Rows{"bottom_up", {-24}, {72}, 8, 4, "", ""},
        Rows{"all_one_row", {0}, {0}, 8, 4, "", ""}, Rows{"overlapping", {1}, {0}, 8, 4, "", ""},
        Rows{"beyond", {25}, {0}, 8, 4, kShort, kRows},
        Rows{"far_beyond", {G_MAXINT}, {0}, 8, 4, kShort, kRows},
        Rows{"before", {-24}, {0}, 8, 4, kShort, kRows},
        Rows{"far_before", {G_MININT}, {0}, 8, 4, kShort, kRows},
        Rows{"offset_at_the_end", {24}, {96}, 8, 4, kShort, kShort},
        Rows{"offset_beyond", {24}, {G_MAXSIZE}, 8, 4, kShort, kShort},
        Rows{"offset_of_a_pixel", {24}, {3}, 8, 4, kShort, kRows},
        Rows{"smaller_picture", {24}, {0}, 4, 4, kOther, kOther},
        Rows{"lower_picture", {24}, {0}, 8, 2, kOther, kOther},
        Rows{"empty_picture", {24}, {0}, 0, 0, kOther, kOther},
        Rows{"other_format", {32}, {0}, 8, 3, kOther, kOther, GST_VIDEO_FORMAT_RGBA},
        Rows{"more_planes", {8, 8}, {0, 32}, 8, 4, kOther, kOther, GST_VIDEO_FORMAT_NV12}),
    [](const auto& info) { return std::string(info.param.name); });

// Padded rows with a truncated last row, and rows without the padding that the caps imply.
TEST(PaddedRows, ThatAreTruncatedOrMissingAreReported) {
  for (const std::string line : {"tensor_converter", "tensor_preprocess width=4 height=4"}) {
    Bench bench(line);
    ASSERT_EQ(bench.start(video("GRAY8", 5, 2)), "");
    EXPECT_EQ(bench.push(zeros(16)), "") << "rows of 8 bytes";
    for (const size_t bytes : {size_t{15}, size_t{13}}) {
      const std::string cut = bench.push(zeros(bytes));
      EXPECT_SAYS(cut, "WEIR-2004: a video buffer is smaller than its caps require");
      EXPECT_SAYS(cut, "offered: " + std::to_string(bytes) + " bytes\n  needed: 16 bytes");
      EXPECT_SAYS(cut, "fix: check the upstream element");
    }
    const std::string bare = bench.push(zeros(10));
    EXPECT_SAYS(bare,
                "the rows have no padding; in GStreamer, rows of this width are 8 bytes apart");
    EXPECT_SAYS(bare, "fix: gst_buffer_add_video_meta_full()");
    bench.expect_balance(4);
  }
  Bench nv12("tensor_preprocess width=4 height=4");
  ASSERT_EQ(nv12.start(video("NV12", 5, 3)), "");
  EXPECT_SAYS(nv12.push(zeros(15 + 2 * 6)), "the rows have no padding");
}

TEST(PaddedRows, OfAnotherNumberOfPlanesAreReported) {
  Bench bench("tensor_converter");
  ASSERT_EQ(bench.start(video("RGBP", 4, 2)), "");
  gsize offsets[] = {0, 8};
  gint strides[] = {4, 4};
  GstBuffer* in = zeros(24);
  gst_buffer_add_video_meta_full(in, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_RGBP, 4, 2, 2,
                                 offsets, strides);
  EXPECT_SAYS(bench.push(in), "offered: RGBP 4x2 in planes: 2\n  needed: RGBP 4x2 in planes: 3");
}

struct Size {
  int width, height;
};
void PrintTo(const Size& size, std::ostream* out) {
  *out << size.width << "x" << size.height;
}
class PictureSize : public testing::TestWithParam<Size> {};

TEST_P(PictureSize, IsAcceptedInEveryFormat) {
  const auto [width, height] = GetParam();
  for (const char* format : {"RGB", "BGR", "RGBx", "xBGR", "RGBA", "ABGR", "GRAY8", "GRAY16_LE",
                             "RGBP", "NV12", "NV21", "I420", "YV12", "YUY2", "UYVY"}) {
    GstVideoInfo info;
    gst_video_info_set_format(&info, gst_video_format_from_string(format),
                              static_cast<guint>(width), static_cast<guint>(height));
    for (const std::string line : {"tensor_converter", "tensor_preprocess width=5 height=3",
                                   "tensor_preprocess width=5 height=3 method=area",
                                   "tensor_preprocess width=1 height=1 fit=letterbox"}) {
      const bool yuv = GST_VIDEO_INFO_IS_YUV(&info);
      const bool other = std::string(format) == "RGBP" || std::string(format) == "GRAY16_LE";
      if (line == "tensor_converter" ? yuv : other) continue;
      Bench bench(line);
      ASSERT_EQ(bench.start(video(format, width, height)), "") << format << " " << line;
      EXPECT_EQ(bench.push(zeros(info.size)), "") << format << " " << line;
      EXPECT_EQ(bench.outputs(), 1u);
      bench.expect_balance(1);
    }
  }
}
INSTANTIATE_TEST_SUITE_P(All, PictureSize,
                         testing::Values(Size{1, 1}, Size{1, 7}, Size{7, 1}, Size{3, 5},
                                         Size{17, 2}, Size{4096, 1}, Size{1, 4096}),
                         [](const auto& info) {
                           return std::to_string(info.param.width) + "x" +
                                  std::to_string(info.param.height);
                         });

// Zero pages that are never written use no memory.
GstBuffer* untouched(size_t bytes) {
  void* pages = std::calloc(bytes, 1);
  return gst_buffer_new_wrapped_full(GST_MEMORY_FLAG_READONLY, pages, bytes, 0, bytes, pages,
                                     std::free);
}

TEST(EnormousPicture, IsReadInPlace) {
  constexpr int kSide = 16384;
  for (const std::string line : {"tensor_converter",
                                 "tensor_preprocess width=4 height=4 "
                                 "method=nearest"}) {
    Bench bench(line);
    ASSERT_EQ(bench.start(video("GRAY8", kSide, kSide)), "") << line;
    EXPECT_EQ(bench.push(untouched(size_t{kSide} * kSide)), "") << line;
    EXPECT_EQ(bench.outputs(), 1u) << line;
    EXPECT_SAYS(bench.push(zeros(96)),
                "WEIR-2004: a video buffer is smaller than its caps require");
    EXPECT_EQ(bench.stat("bytes-copied"), 0u);
    bench.expect_balance(2);
  }
}

TEST(EnormousPicture, IsRejectedIfItsSizeOverflows) {
  for (const std::string line :
       {"tensor_converter", "tensor_converter frames-per-tensor=4294967295",
        "tensor_preprocess width=4 height=4"}) {
    Bench bench(line);
    EXPECT_NE(bench.start(video("RGBA", G_MAXINT, G_MAXINT)), "") << line;
    bench.expect_balance(0);
    bench.stop();
  }
}

TEST(EnormousTensor, IsReportedBeforeItIsAllocated) {
  const std::string dims = "65536:65536:256";  // a tebibyte of bytes
  for (const auto& subject : subjects()) {
    const std::string name = subject.name;
    if (!name.starts_with("transform") && name != "decoder" && name != "filter") continue;
    Bench bench(subject);
    const std::string refused = bench.start(tensors(dims, "uint8"));
    const std::string error = refused.empty() ? bench.push(zeros(16)) : refused;
    EXPECT_TRUE(error.find("WEIR-2") != std::string::npos ||
                error.find("WEIR-9001") != std::string::npos)
        << name << ": " << error;
    expect_sound_again(bench, subject, refused.empty() ? 1 : 0);
  }
}

}  // namespace bad_video_test
