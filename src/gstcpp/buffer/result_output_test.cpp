// Tests frames without results, and the place of results in their picture.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/result_output.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "gstcpp/buffer/tensor_meta.hpp"
#include "says.hpp"

namespace weir::gst {
namespace result_output_test {

constexpr size_t kHeader = 128;  // bytes of a flexible tensor's header, docs/compatibility

// The output of caps with these columns; none without them.
ResultOutput output_of(const std::string& columns) {
  std::string text = "other/tensors,format=flexible";
  if (!columns.empty()) text += ",weir-columns=(string)\"" + columns + "\",weir-source=(string)net";
  const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(text.c_str()));
  ResultOutput out;
  out.configure(caps.get());
  return out;
}
// 17 tensors, one more than a buffer has memories.
std::string many_columns() {
  std::string out = "score\\,class";
  for (int i = 1; i < 17; ++i) out += ";text";
  return out;
}
Ref<GstBuffer> frame_of(const ResultOutput& output) {
  const BufferLimit limit("tensor_decoder");
  auto frame = output.empty_frame(limit);
  EXPECT_TRUE(frame) << (frame ? "" : frame.error().message());
  return frame ? *std::move(frame) : Ref<GstBuffer>();
}
std::vector<gsize> sizes_of(GstBuffer* frame) {
  std::vector<gsize> out;
  for (guint i = 0; i < gst_buffer_n_memory(frame); ++i)
    out.push_back(gst_memory_get_sizes(gst_buffer_peek_memory(frame, i), nullptr, nullptr));
  return out;
}

TEST(ResultOutput, KnowsResultsByTheirCaps) {
  EXPECT_TRUE(output_of("score\\,class").is_results());
  EXPECT_EQ(output_of("score\\,class").source(), "net");
  ResultOutput other = output_of("");
  EXPECT_FALSE(other.is_results());
  EXPECT_EQ(other.source(), "");
  other.configure(nullptr);
  EXPECT_FALSE(other.is_results());
}

TEST(ResultOutput, AFrameWithoutResultsHasOneRowOfZerosInEachTensor) {
  const auto frame = frame_of(output_of("x1\\,y1\\,x2\\,y2\\,score\\,class;masks;depth"));
  ASSERT_TRUE(frame);
  EXPECT_EQ(sizes_of(frame.get()),
            (std::vector<gsize>{kHeader + 6 * 4, kHeader + 1, kHeader + 1 * 4}));
  std::vector<uint8_t> bytes(gst_buffer_get_size(frame.get()));
  gst_buffer_extract(frame.get(), 0, bytes.data(), bytes.size());
  EXPECT_TRUE(std::all_of(bytes.begin() + kHeader, bytes.begin() + kHeader + 6 * 4,
                          [](uint8_t byte) { return byte == 0; }));
  EXPECT_FALSE(GST_BUFFER_PTS_IS_VALID(frame.get()));
}

TEST(ResultOutput, AFrameOf17TensorsHas16Memories) {
  const auto frame = frame_of(output_of(many_columns()));
  ASSERT_TRUE(frame);
  const auto sizes = sizes_of(frame.get());
  ASSERT_EQ(sizes.size(), 16u);
  EXPECT_EQ(sizes[0], kHeader + 2 * 4);
  EXPECT_EQ(sizes[14], kHeader + 1);
  EXPECT_EQ(sizes[15], 2 * (kHeader + 1));
}

TEST(ResultOutput, MakesNoFrameOfColumnsThatAreNotValid) {
  EXPECT_FALSE(frame_of(output_of("score\\,score")));
}

TEST(ResultOutput, AFrameBeyondTheLimitIsAnError) {
  const auto output = output_of("score\\,class;text");
  BufferLimit limit("tensor_decoder");
  const size_t bytes = 2 * kHeader + 2 * 4 + 1;
  limit.set_bytes(bytes);
  EXPECT_TRUE(output.empty_frame(limit));
  limit.set_bytes(bytes - 1);
  const auto refused = output.empty_frame(limit);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::LIMIT_EXCEEDED);
  const std::string text = refused.error().message();
  EXPECT_SAYS(text, "an output buffer of tensor_decoder is larger than max-buffer-size");
  EXPECT_SAYS(text, "265 bytes");
  EXPECT_SAYS(text, "at most 264 bytes");
  EXPECT_SAYS(text, "tensor_decoder max-buffer-size=265");
}

TEST(ResultOutput, AFrameOfAGapHasItsTime) {
  const auto output = output_of("score\\,class");
  const BufferLimit limit("tensor_decoder");
  const Unique<GstEvent, gst_event_unref> gap(gst_event_new_gap(7, 3));
  const auto frame = output.frame_of_gap(gap.get(), limit);
  ASSERT_TRUE(frame && *frame);
  EXPECT_EQ(GST_BUFFER_PTS(frame->get()), 7u);
  EXPECT_EQ(GST_BUFFER_DURATION(frame->get()), 3u);
}

// A network of 4 x 4 sees a picture of 4 x 2 with a border of one row above and below.
TEST(ResultOutput, ResultsAreInPixelsOfThePictureAndMapsCoverTheNetworksInput) {
  ResultOutput output = output_of("score\\,class;class-map");
  auto frame = frame_of(output);
  SourceMap letterbox;
  letterbox.width = letterbox.height = 4;
  letterbox.source_width = 4, letterbox.source_height = 2;
  letterbox.y0 = -1;
  set_source_maps(frame.get(), {letterbox});
  ASSERT_TRUE(output.place(frame.get()));
  const auto maps = source_maps(frame.get());
  ASSERT_EQ(maps.size(), 2u);
  EXPECT_EQ(maps[0].to_source({1, 1}).x, 1);
  EXPECT_EQ(maps[0].to_source({1, 1}).y, 1);
  EXPECT_EQ(maps[1].to_source({0.5, 0.5}).x, 2) << "the centre of the only cell";
  EXPECT_EQ(maps[1].to_source({0.5, 0.5}).y, 1);
  EXPECT_EQ(maps[1].width, 1u);
}

TEST(ResultOutput, FramesThatComeFromNoPictureGetNoPlace) {
  ResultOutput output = output_of("score\\,class");
  auto frame = frame_of(output);
  ASSERT_TRUE(output.place(frame.get()));
  EXPECT_TRUE(source_maps(frame.get()).empty());
}

TEST(ResultOutput, AMapWhoseBytesAreNoTensorIsAnError) {
  ResultOutput output = output_of("class-map");
  auto frame = Ref<GstBuffer>::adopt(gst_buffer_new_allocate(nullptr, 3, nullptr));
  set_source_maps(frame.get(), {picture_as_it_is(4, 2, false)});
  const Status status = output.place(frame.get());
  ASSERT_FALSE(status);
  EXPECT_SAYS(status.error().message(), "3 bytes");
}

}  // namespace result_output_test
}  // namespace weir::gst
