// Video buffers with planes that continue in the next memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <numeric>

#include "elements/tests/bad_input_bench_test_support.hpp"

namespace split_video_test {

using namespace weir::testing_bad_input;
using weir::test::Bytes;

Bytes ramp(size_t bytes) {
  Bytes out(bytes);
  std::iota(out.begin(), out.end(), uint8_t{0});
  return out;
}

struct Layout {
  const char* name;
  GstVideoFormat format;
  guint width, height;
  std::vector<gsize> offsets;
  std::vector<gint> strides;
  size_t bytes;  // of the buffer
};
void PrintTo(const Layout& layout, std::ostream* out) {
  *out << layout.name;
}

// `bytes` in memories that start at 0 and at each of `cuts`, with the layout's GstVideoMeta.
GstBuffer* picture(const Layout& layout, const Bytes& bytes, const std::vector<size_t>& cuts) {
  GstBuffer* buffer = gst_buffer_new();
  size_t begin = 0;
  const auto append = [&](size_t end) {
    const auto at = [&](size_t n) { return bytes.begin() + static_cast<std::ptrdiff_t>(n); };
    gst_buffer_append_memory(buffer, weir::test::make_memory(Bytes(at(begin), at(end))));
    begin = end;
  };
  for (const size_t cut : cuts) append(cut);
  append(bytes.size());
  auto offsets = layout.offsets;
  auto strides = layout.strides;
  gst_buffer_add_video_meta_full(buffer, GST_VIDEO_FRAME_FLAG_NONE, layout.format, layout.width,
                                 layout.height, static_cast<guint>(offsets.size()), offsets.data(),
                                 strides.data());
  return buffer;
}

class SplitVideo : public testing::TestWithParam<Layout> {
 protected:
  // The element's output for the picture split at `cuts`.
  static Bytes make_output(const std::string& line, const std::vector<size_t>& cuts) {
    const Layout& layout = GetParam();
    Bench bench(line);
    EXPECT_EQ(bench.start(video(gst_video_format_to_string(layout.format),
                                static_cast<int>(layout.width), static_cast<int>(layout.height))),
              "");
    bench.keep_bytes();
    EXPECT_EQ(bench.push(picture(layout, ramp(layout.bytes), cuts)), "") << line;
    bench.expect_balance(1);
    return bench.bytes();
  }
  static void expect_same_for_every_cut(const std::string& line, const Bytes& expected) {
    const size_t bytes = GetParam().bytes;
    EXPECT_EQ(make_output(line, {}), expected) << line;
    for (size_t cut = 1; cut < bytes; ++cut)
      EXPECT_EQ(make_output(line, {cut}), expected) << line << ", cut at " << cut;
    for (size_t cut = 1; cut + 1 < bytes; cut += 3)
      EXPECT_EQ(make_output(line, {cut, cut + 1}), expected) << line << ", cuts at " << cut;
  }
};

const Layout kRgb{"rgb", GST_VIDEO_FORMAT_RGB, 5, 4, {0}, {16}, 64};
const Layout kNoPaddingAtTheEnd{"no_padding_at_the_end", GST_VIDEO_FORMAT_RGB, 5, 4, {1}, {16}, 64};
const Layout kBottomUp{"bottom_up", GST_VIDEO_FORMAT_RGB, 5, 4, {48}, {-16}, 64};
const Layout kPlanes{"planes", GST_VIDEO_FORMAT_RGBP, 5, 3, {2, 30, 58}, {8, 8, 8}, 84};
const Layout kNv12{"nv12", GST_VIDEO_FORMAT_NV12, 6, 4, {0, 32}, {8, 8}, 48};

std::string make_test_name(const testing::TestParamInfo<Layout>& info) {
  return info.param.name;
}

class ConvertedSplitVideo : public SplitVideo {};
INSTANTIATE_TEST_SUITE_P(All, ConvertedSplitVideo,
                         testing::Values(kRgb, kNoPaddingAtTheEnd, kBottomUp, kPlanes),
                         make_test_name);

// The tensor holds the rows without padding, plane after plane.
TEST_P(ConvertedSplitVideo, HasEachRow) {
  const Layout& layout = GetParam();
  const size_t row_bytes = layout.width * (layout.format == GST_VIDEO_FORMAT_RGB ? 3 : 1);
  Bytes expected;
  for (size_t plane = 0; plane < layout.offsets.size(); ++plane)
    for (int row = 0; row < static_cast<int>(layout.height); ++row)
      for (size_t x = 0; x < row_bytes; ++x)
        expected.push_back(static_cast<uint8_t>(static_cast<int>(layout.offsets[plane] + x) +
                                                row * layout.strides[plane]));
  expect_same_for_every_cut("tensor_converter", expected);
}

class PreparedSplitVideo : public SplitVideo {};
INSTANTIATE_TEST_SUITE_P(All, PreparedSplitVideo,
                         testing::Values(kRgb, kNoPaddingAtTheEnd, kBottomUp, kNv12),
                         make_test_name);

TEST_P(PreparedSplitVideo, GivesTheSameTensorAsOneMemory) {
  const std::string line = "tensor_preprocess width=4 height=4 method=nearest";
  const Bytes expected = make_output(line, {});
  ASSERT_FALSE(expected.empty());
  expect_same_for_every_cut(line, expected);
}

TEST(SplitVideoWithoutMetadata, IsConvertedWhole) {
  for (size_t cut = 1; cut < 64; ++cut) {
    Bench bench("tensor_converter");
    ASSERT_EQ(bench.start(video("RGB", 5, 4)), "");
    bench.keep_bytes();
    const Bytes bytes = ramp(64);
    const auto middle = bytes.begin() + static_cast<std::ptrdiff_t>(cut);
    GstBuffer* in = gst_buffer_new();
    gst_buffer_append_memory(in, weir::test::make_memory(Bytes(bytes.begin(), middle)));
    gst_buffer_append_memory(in, weir::test::make_memory(Bytes(middle, bytes.end())));
    ASSERT_EQ(bench.push(in), "");
    Bytes expected;
    for (int row = 0; row < 4; ++row)
      for (int x = 0; x < 15; ++x) expected.push_back(static_cast<uint8_t>(16 * row + x));
    EXPECT_EQ(bench.bytes(), expected) << cut;
    EXPECT_EQ(bench.stat("bytes-copied"), 64u + 60);
  }
}

// Planes with one memory each are read in place.
TEST(SplitVideoPlanes, InSeparateMemoriesAreCopiedOnce) {
  const Layout layout{"", GST_VIDEO_FORMAT_RGBP, 5, 2, {0, 16, 32}, {8, 8, 8}, 48};
  Bench bench("tensor_converter");
  ASSERT_EQ(bench.start(video("RGBP", 5, 2)), "");
  ASSERT_EQ(bench.push(picture(layout, ramp(48), {16, 32})), "");
  EXPECT_EQ(bench.stat("bytes-copied"), 30u);
}

}  // namespace split_video_test
