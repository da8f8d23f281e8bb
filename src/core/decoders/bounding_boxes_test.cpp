// Tests of bounding_boxes: pixels of boxes and labels, tracking, logging, and unusable options.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <array>

#include "core/decoders/decoder_test_support.hpp"
#include "core/draw/glyphs.hpp"

namespace weir::decoders {
namespace bounding_boxes_test {

constexpr const char* kMode = "bounding_boxes";

// The output as rows of text: '#' red, '.' transparent, '?' anything else.
std::vector<std::string> rows_of(const Bytes& pixels, size_t width) {
  std::vector<std::string> rows;
  for (size_t at = 0; at + 4 <= pixels.size(); at += 4) {
    if (at / 4 % width == 0) rows.emplace_back();
    const Bytes pixel(pixels.begin() + at, pixels.begin() + at + 4);
    rows.back() += pixel == Bytes{255, 0, 0, 255} ? '#' : pixel == Bytes(4) ? '.' : '?';
  }
  return rows;
}

// Rows of TFLite_Detection_PostProcess: each box is top, left, bottom, right, class, score.
std::vector<TestTensor> postprocessed(const std::vector<std::array<float, 6>>& rows) {
  std::vector<float> boxes, classes, scores;
  for (const auto& row : rows) {
    boxes.insert(boxes.end(), row.begin(), row.begin() + 4);
    classes.push_back(row[4]);
    scores.push_back(row[5]);
  }
  const std::string count = std::to_string(rows.size());
  return {{"4:" + count + ":1", boxes},
          {count + ":1", classes},
          {count + ":1", scores},
          {"1", {static_cast<float>(rows.size())}}};
}
DecoderOptions options(const std::string& output, const std::string& input,
                       const DecoderOptions& more = {}) {
  DecoderOptions all{{"option1", "mobilenet-ssd-postprocess"},
                     {"option3", "0:1:2:3,50"},
                     {"option4", output},
                     {"option5", input}};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}
const std::array<float, 6> kBox{0.25f, 0.25f, 0.75f, 0.75f, 1, 0.75f};

std::vector<std::string> drawn(const DecoderOptions& given, const std::vector<TestTensor>& tensors,
                               size_t width) {
  TestDecoder decoder(kMode, given);
  decoder.decode(tensors);
  EXPECT_EQ(decoder.error, "");
  return rows_of(decoder.output, width);
}

TEST(BoundingBoxes, DrawsABoxOfOnePixelOnATransparentFrame) {
  TestDecoder decoder(kMode, options("8:8", "8:8"));
  ASSERT_TRUE(decoder.configure(postprocessed({kBox}))) << decoder.error;
  EXPECT_EQ(decoder.caps, "video/x-raw,format=(string)RGBA,width=(int)8,height=(int)8");
  EXPECT_EQ(rows_of(decoder.decode(postprocessed({kBox})), 8),
            (std::vector<std::string>{"........",  //
                                      "........",  //
                                      "..#####.",  //
                                      "..#...#.",  //
                                      "..#...#.",  //
                                      "..#...#.",  //
                                      "..#####.",  //
                                      "........"}));
}

TEST(BoundingBoxes, ReadsQuantisedOutputsAsTheModelMeansThem) {
  const std::vector<TestTensor> tensors{{ElementType::UInt8, "4:1:1", Bytes{1, 1, 3, 3}},
                                        {ElementType::UInt8, "1:1", Bytes{4}},
                                        {ElementType::UInt8, "1:1", Bytes{3}},
                                        {ElementType::UInt8, "1", Bytes{4}}};
  TestDecoder decoder(kMode, options("8:8", "8:8"));
  decoder.set_model(tensors, 0.25f, 0);
  EXPECT_EQ(rows_of(decoder.decode(tensors), 8),
            drawn(options("8:8", "8:8"), postprocessed({kBox}), 8));
  EXPECT_EQ(decoder.error, "");
}

TEST(BoundingBoxes, ScalesToTheOutputAndEndsAtItsEdge) {
  // x: 6 * 2 / 8 = 1, 6 * 8 / 8 = 6, which is beyond the last column.
  EXPECT_EQ(drawn(options("6:4", "8:8"), postprocessed({{0.25f, 0.25f, 1, 1, 0, 1}}), 6),
            (std::vector<std::string>{"......",  //
                                      ".#####",  //
                                      ".#...#",  //
                                      ".#####"}));
}

TEST(BoundingBoxes, AFrameWithoutDetectionsIsTransparent) {
  auto tensors = postprocessed({kBox});
  tensors[3] = {"1", {0}};
  EXPECT_EQ(drawn(options("3:2", "8:8"), tensors, 3), (std::vector<std::string>{"...", "..."}));
}

TEST(BoundingBoxes, ALabelIsAboveItsBox) {
  const std::string labels = file_with("labels.txt", "cat\n#\n");
  const auto rows = drawn(options("32:32", "32:32", {{"option2", labels}}),
                          postprocessed({{0.5f, 0.25f, 0.75f, 0.75f, 1, 1}}), 32);
  ASSERT_EQ(rows.size(), 32u);
  const draw::Glyph& glyph = draw::get_glyph('#');
  for (size_t y = 0; y < 16; ++y)  // 14 above the edge at 16, and one free row
    for (size_t x = 0; x < 32; ++x) {
      const bool is_in_cell = y >= 2 && y < 15 && x >= 8 && x < 16;
      const bool is_set = is_in_cell && glyph[y - 2] & (0x80 >> (x - 8));
      EXPECT_EQ(rows[y][x], is_set ? '#' : '.') << x << " " << y;
    }
  EXPECT_EQ(rows[16], "........#################.......");
}

// Cells are written after the box, so that they replace the edge below them.
TEST(BoundingBoxes, ALabelAtTheTopReplacesTheEdgeOfItsBox) {
  const std::string labels = file_with("labels.txt", " \n");
  const auto rows = drawn(options("16:32", "16:32", {{"option2", labels}}),
                          postprocessed({{0.25f, 0, 0.75f, 0.5f, 0, 1}}), 16);
  EXPECT_EQ(rows[7], "................");
  EXPECT_EQ(rows[8], "........#.......");
  EXPECT_EQ(rows[12], "........#.......");
  EXPECT_EQ(rows[13], "#.......#.......") << "below the 13 rows of the cell";
}

TEST(BoundingBoxes, BoxesWithoutALabelAreNotDrawn) {
  const LogLines log;
  const std::string labels = file_with("labels.txt", "cat\n");
  TestDecoder decoder(kMode, options("8:8", "8:8", {{"option2", labels}}));
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(decoder.decode(postprocessed({kBox})), Bytes(8 * 8 * 4)) << decoder.error;
    decoder.decode(postprocessed({{0, 0, 1, 1, -1, 1}}));
  }
  EXPECT_EQ(LogLines::lines,
            std::vector<std::string>{"2 bounding_boxes: boxes of class 1 are not drawn: the label "
                                     "file has 1 labels"});
}

TEST(BoundingBoxes, OptionsMayHaveAnyOrder) {
  const std::string labels = file_with("labels.txt", "a\nb\n");
  DecoderOptions given = options("40:40", "40:40", {{"option2", labels}, {"option6", "1"}});
  const auto tensors = postprocessed({kBox});
  const auto expected = drawn(given, tensors, 40);
  std::sort(given.begin(), given.end());
  do {
    EXPECT_EQ(drawn(given, tensors, 40), expected);
  } while (std::next_permutation(given.begin(), given.end()));
}

TEST(BoundingBoxes, EachDecoderHasItsOwnParameters) {
  auto other = options("8:8", "8:8");
  other[1].second = "0:1:2:3,80";
  TestDecoder low(kMode, options("8:8", "8:8")), high(kMode, other);
  const auto tensors = postprocessed({kBox});
  EXPECT_NE(low.decode(tensors), Bytes(8 * 8 * 4));
  EXPECT_EQ(high.decode(tensors), Bytes(8 * 8 * 4));
  EXPECT_NE(low.decode(tensors), Bytes(8 * 8 * 4));
}

// "#-1" and "#-2" differ in the third cell.
TEST(BoundingBoxes, TrackingWritesTheNumberOfTheObject) {
  const std::string labels = file_with("labels.txt", "#\n#\n");
  const auto tracked = options("64:64", "64:64", {{"option2", labels}, {"option6", "1"}});
  TestDecoder decoder(kMode, tracked);
  const std::array<float, 6> left{0.5f, 0, 0.75f, 0.25f, 0, 1};
  const std::array<float, 6> right{0.5f, 0.5f, 0.75f, 0.75f, 0, 1};
  const Bytes first = decoder.decode(postprocessed({left}));
  EXPECT_EQ(decoder.decode(postprocessed({left})), first);
  const Bytes both = decoder.decode(postprocessed({right, left}));
  const auto cell = [&](const Bytes& frame, size_t x) {
    Bytes out;
    for (size_t y = 18; y < 31; ++y)
      for (size_t i = 0; i < 32; ++i) out.push_back(frame[(y * 64 + x + 18) * 4 + i]);
    return out;
  };
  EXPECT_EQ(cell(both, 0), cell(first, 0)) << "still 1";
  EXPECT_NE(cell(both, 32), cell(first, 0)) << "2";
  decoder.reset();
  const Bytes again = decoder.decode(postprocessed({right}));
  EXPECT_EQ(cell(again, 32), cell(first, 0)) << "numbers begin again after a flush";
}

TEST(BoundingBoxes, LogsTheBoxesOfEachFrame) {
  const LogLines log;
  const std::string labels = file_with("labels.txt", "cat\ndog\n");
  TestDecoder decoder(kMode, options("8:8", "16:8", {{"option2", labels}, {"option7", "1"}}));
  decoder.decode(postprocessed({kBox}));
  EXPECT_EQ(LogLines::lines,
            (std::vector<std::string>{"3 bounding_boxes: Detect 1 boxes in 16 x 8 input image",
                                      "3 bounding_boxes: [dog] x:4 y:2 w:8 h:4 prob:0.7500"}));
}

TEST(BoundingBoxes, TheOldNamesMeanTheSame) {
  auto old_name = options("8:8", "8:8");
  old_name[0].second = "tf-ssd";
  TestDecoder decoder("bounding_box", old_name);
  EXPECT_EQ(rows_of(decoder.decode(postprocessed({kBox})), 8),
            drawn(options("8:8", "8:8"), postprocessed({kBox}), 8));
}

// The same numbers as bytes: every box of the frame, in every type.
TEST(BoundingBoxes, ReadsEveryElementType) {
  const auto expected = drawn(options("8:8", "8:8"), postprocessed({{0, 0, 1, 1, 1, 1}}), 8);
  const auto expect_of = [&]<class T>(ElementType type, T one) {
    const T zero{};
    const std::vector<TestTensor> tensors{{type, "4:1:1", std::vector<T>{zero, zero, one, one}},
                                          {type, "1:1", std::vector<T>{one}},
                                          {type, "1:1", std::vector<T>{one}},
                                          {type, "1", std::vector<T>{one}}};
    EXPECT_EQ(drawn(options("8:8", "8:8"), tensors, 8), expected) << static_cast<int>(type);
  };
  expect_of(ElementType::Int8, int8_t{1});
  expect_of(ElementType::UInt8, uint8_t{1});
  expect_of(ElementType::Int16, int16_t{1});
  expect_of(ElementType::UInt16, uint16_t{1});
  expect_of(ElementType::Int32, int32_t{1});
  expect_of(ElementType::UInt32, uint32_t{1});
  expect_of(ElementType::Int64, int64_t{1});
  expect_of(ElementType::UInt64, uint64_t{1});
  expect_of(ElementType::Float64, double{1});
  expect_of(ElementType::Float16, float16(1.f));
}

}  // namespace bounding_boxes_test
}  // namespace weir::decoders
