// Tests of pose_estimation: pixels of lines, dots and names, and input that it rejects.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>
#include <set>

#include "core/decoders/decoder_test_support.hpp"
#include "core/draw/glyphs.hpp"

namespace weir::decoders {
namespace pose_estimation_test {

constexpr const char* kMode = "pose_estimation";
using Place = std::pair<int, int>;  // x, y

// A frame in which pixels are set one by one.
struct Expected {
  int width, height;
  Bytes bytes = Bytes(static_cast<size_t>(4 * width * height));

  void set(int x, int y, uint8_t value = 255) {
    if (x < 0 || y < 0 || x >= width || y >= height) return;
    std::memset(&bytes[static_cast<size_t>(4 * (y * width + x))], value, 4);
  }
  // The list of docs/compatibility/decoder.md 5.4.
  void dot(int x, int y) {
    const auto column = [&](int dx, int reach) {
      for (int dy = -reach; dy <= reach; ++dy) {
        if (dx == 0 && dy == 0) continue;
        set(x + dx, y + dy);
        set(x - dx, y + dy);
      }
    };
    column(3, 1);
    column(2, 2);
    column(1, 3);
    column(0, 3);
    for (const auto& [dx, dy] : {Place{4, 0}, {-4, 0}, {0, 4}, {0, -4}}) set(x + dx, y + dy);
  }
  void thick(int x, int y) {
    set(x, y);
    set(x + 1, y);
    set(x, y + 1);
  }
  void text(int x, int y, const std::string& text) {
    y = std::max(0, y - 14);
    for (const char character : text) {
      if (x + 8 > width) return;
      for (int row = 0; row < 13; ++row)
        for (int column = 0; column < 8; ++column)
          set(x + column, y + row, draw::get_glyph(character)[row] & 0x80 >> column ? 255 : 0);
      x += 9;
    }
  }
};

// Heat maps of `points` key points with probability 0.9 at the given cells and 0.1 elsewhere.
std::vector<float> maps(size_t points, int width, int height, const std::vector<Place>& cells,
                        float high = 0.9f, float low = 0.1f) {
  std::vector<float> out(points * static_cast<size_t>(width * height), low);
  for (size_t i = 0; i < cells.size(); ++i)
    if (cells[i].first >= 0)
      out[static_cast<size_t>(cells[i].second * width + cells[i].first) * points + i] = high;
  return out;
}
std::string body_file(const std::string& text) {
  return file_with("body.txt", text);
}
DecoderOptions options(const std::string& output, const std::string& input,
                       const std::string& file = "", const std::string& kind = "") {
  DecoderOptions out{{"option1", output}, {"option2", input}};
  if (!file.empty()) out.emplace_back("option3", file);
  if (!kind.empty()) out.emplace_back("option4", kind);
  return out;
}
Bytes drawn(const DecoderOptions& options, const std::vector<TestTensor>& tensors) {
  TestDecoder decoder(kMode, options);
  if (decoder.error.empty() && decoder.configure(tensors)) decoder.decode(tensors);
  EXPECT_EQ(decoder.error, "");
  return decoder.output;
}

TEST(PoseEstimation, DrawsALineBetweenTwoKeyPoints) {
  // Cells 2, 5 and 8, 5 of a grid of 10 x 10 are pixels 16, 35 and 64, 35 of 80 x 70.
  Expected expected{80, 70};
  expected.dot(16, 35);
  expected.dot(64, 35);
  for (int x = 16; x <= 64; ++x) expected.thick(x, 35);
  expected.text(16, 35, "a");
  expected.text(64, 35, "b");
  const std::string file = body_file("a 1\nb\n");
  EXPECT_EQ(
      drawn(options("80:70", "10:10", file), {{"2:10:10", maps(2, 10, 10, {{2, 5}, {8, 5}})}}),
      expected.bytes);
  EXPECT_EQ(drawn(options("80:70", "10:10", file, "heatmap-only"),
                  {{"2:10:10:1", maps(2, 10, 10, {{2, 5}, {8, 5}})}}),
            expected.bytes)
      << "the same, with every option";
}

TEST(PoseEstimation, DrawsALineFromItsLeftEnd) {
  // A line of slope -1/2, by hand: two columns for each row.
  Expected expected{40, 40};
  expected.dot(10, 20);
  expected.dot(20, 15);
  const std::set<Place> steps{{10, 20}, {11, 19}, {12, 19}, {13, 18}, {14, 18}, {15, 17},
                              {16, 17}, {17, 16}, {18, 16}, {19, 15}, {20, 15}};
  for (const auto& [x, y] : steps) expected.thick(x, y);
  const auto without_names = [&](const std::vector<Place>& cells) {
    Bytes out = drawn(options("40:40", "40:40", body_file("* 1\n*\n")),
                      {{"2:40:40", maps(2, 40, 40, cells)}});
    return out;
  };
  expected.text(10, 20, "*");
  expected.text(20, 15, "*");
  EXPECT_EQ(without_names({{10, 20}, {20, 15}}), expected.bytes);
  EXPECT_EQ(without_names({{20, 15}, {10, 20}}), expected.bytes);
}

// All 14 at different cells: every line of the default body, and names over lines.
TEST(PoseEstimation, DrawsTheDefaultBody) {
  const std::vector<Place> cells{{5, 0}, {5, 2}, {3, 2}, {2, 4}, {1, 6}, {7, 2}, {8, 4},
                                 {9, 6}, {4, 6}, {4, 8}, {4, 9}, {6, 6}, {6, 8}, {6, 9}};
  const Bytes all = drawn(options("200:300", "10:10"), {{"14:10:10", maps(14, 10, 10, cells)}});
  size_t white = 0;
  for (size_t i = 0; i < all.size(); i += 4) white += all[i] == 255 && all[i + 3] == 255;
  EXPECT_GT(white, 13u * 60);
  // The middle of each straight line of limbs that no name covers: wrist to elbow to shoulder.
  const auto is_white = [&](int x, int y) {
    return all[static_cast<size_t>(4 * (y * 200 + x))] == 255;
  };
  EXPECT_TRUE(is_white(30, 150));   // r_elbow (40, 120) to r_wrist (20, 180)
  EXPECT_TRUE(is_white(170, 150));  // l_elbow (160, 120) to l_wrist (180, 180)
  EXPECT_TRUE(is_white(80, 255));   // r_knee (80, 240) to r_ankle (80, 270) below the knee
  EXPECT_FALSE(is_white(100, 250)) << "between the legs";
}

TEST(PoseEstimation, LeavesOutKeyPointsBelowOneHalf) {
  const std::string file = body_file("a 1\nb\n");
  const auto at = [&](float high) {
    return drawn(options("80:70", "10:10", file),
                 {{"2:10:10", maps(2, 10, 10, {{2, 5}, {8, 5}}, high)}});
  };
  EXPECT_EQ(at(std::nextafter(0.5f, 0.f)), Bytes(4 * 80 * 70));
  EXPECT_EQ(at(0.5f), at(0.9f));
  Expected only_a{80, 70};
  only_a.text(16, 35, "a");
  auto one = maps(2, 10, 10, {{2, 5}, {-1, -1}});
  EXPECT_EQ(drawn(options("80:70", "10:10", file), {{"2:10:10", one}}), only_a.bytes)
      << "a name but no dot without a line";
}

TEST(PoseEstimation, NamesErasePartsOfLines) {
  // A line straight up through the name of its lower end.
  Expected expected{40, 60};
  expected.dot(10, 50);
  expected.dot(10, 20);
  for (int y = 20; y <= 50; ++y) expected.thick(10, y);
  expected.text(10, 50, "l");
  expected.text(10, 20, "l");
  EXPECT_EQ(drawn(options("40:60", "4:6", body_file("l 1\nl\n")),
                  {{"2:4:6", maps(2, 4, 6, {{1, 5}, {1, 2}})}}),
            expected.bytes);
}

TEST(PoseEstimation, AddsOffsets) {
  // Grid 5 x 3 over an input of 100 x 50; output 200 x 100.
  const std::string file = body_file("a 1\nb\n");
  auto heat = maps(2, 5, 3, {{1, 2}, {3, 0}}, 4, -4);
  std::vector<float> offsets(4 * 15);
  const auto set = [&](Place cell, size_t point, float x, float y) {
    float* values = &offsets[static_cast<size_t>(cell.second * 5 + cell.first) * 4];
    values[point] = y;
    values[2 + point] = x;
  };
  set({1, 2}, 0, 5.25f, -10);  // 25 + 5.25, 50 - 10 in the input: 60.5, 80 in the output
  set({3, 0}, 1, -3, 40);      // 75 - 3, 0 + 40: 144, 80
  Expected expected{200, 100};
  expected.dot(60, 80);
  expected.dot(144, 80);
  for (int x = 60; x <= 144; ++x) expected.thick(x, 80);
  expected.text(60, 80, "a");
  expected.text(144, 80, "b");
  const std::vector<TestTensor> tensors{{"2:5:3", heat}, {"4:5:3", offsets}};
  EXPECT_EQ(drawn(options("200:100", "100:50", file, "heatmap-offset"), tensors), expected.bytes);
  auto more = tensors;
  more.push_back({"7:5:3", std::vector<float>(105)});
  EXPECT_EQ(drawn(options("200:100", "100:50", file, "heatmap-offset"), more), expected.bytes)
      << "further tensors do not matter";
}

TEST(PoseEstimation, MovesKeyPointsIntoTheFrame) {
  const std::string file = body_file("a\n");
  for (const auto& [offset, x, y] :
       {std::tuple{1e9f, 50, 40}, {-1e9f, 0, 0}, {3e38f, 50, 40}, {-0.5f, 0, 0}}) {
    const std::vector<TestTensor> tensors{{"1:2:2", {9, 0, 0, 0}},
                                          {"2:2:2", {offset, offset, 0, 0, 0, 0, 0, 0}}};
    Expected expected{50, 40};
    expected.text(x, y, "a");
    EXPECT_EQ(drawn(options("50:40", "50:40", file, "heatmap-offset"), tensors), expected.bytes)
        << offset;
  }
  Expected expected{50, 40};  // the grid is larger than option2 says
  expected.text(30, 40, "a");
  EXPECT_EQ(drawn(options("50:40", "5:2", file), {{"1:5:5", maps(1, 5, 5, {{3, 4}})}}),
            expected.bytes);
}

TEST(PoseEstimation, SetsTheCapsFromTheOptions) {
  TestDecoder decoder(kMode, options("640:480", "10:10"));
  EXPECT_TRUE(decoder.configure({{"14:10:10", {}}})) << decoder.error;
  EXPECT_EQ(decoder.caps, "video/x-raw,format=(string)RGBA,width=(int)640,height=(int)480");
  decoder.caps.clear();
  EXPECT_TRUE(decoder.configure({})) << "a flexible stream: " << decoder.error;
  EXPECT_SAYS(decoder.caps, "width=(int)640");
}

TEST(PoseEstimation, KeepsItsOwnKeyPoints) {
  TestDecoder few(kMode, options("20:20", "2:2", body_file("a\nb\n")));
  TestDecoder many(kMode, options("20:20", "2:2"));
  EXPECT_TRUE(few.configure({{"2:2:2", {}}})) << few.error;
  EXPECT_TRUE(many.configure({{"14:2:2", {}}})) << many.error;
  few.decode({{"2:2:2", maps(2, 2, 2, {})}});
  EXPECT_EQ(few.error, "");
}

TEST(PoseEstimation, NeedsSizes) {
  EXPECT_SAYS(error_of(kMode, {}, {}), "WEIR-1004: option1 is required");
  const auto no_input = error_of(kMode, {{"option1", "640:480"}}, {});
  EXPECT_SAYS(no_input, "WEIR-1004: option2 is required");
  EXPECT_SAYS(no_input, "needed: the size of the heat map as WIDTH:HEIGHT");
  EXPECT_SAYS(error_of(kMode, {{"option1", "640:480"}, {"option4", "heatmap-offset"}}, {}),
              "needed: the size of the model's input as WIDTH:HEIGHT");
  for (const char* size : {"0:480", "640:0", "0:0"}) {
    EXPECT_SAYS(error_of(kMode, options(size, "10:10"), {}), "WEIR-1004: option1 is a size that");
    EXPECT_SAYS(error_of(kMode, options("640:480", size), {}), std::string("option2=") + size);
  }
  for (const char* size : {"640", "640x480", "640:480:3", "-1:480", "a:b"})
    EXPECT_SAYS(error_of(kMode, options(size, "10:10"), {}), "WEIR-1001: option1 is not a size");
}

TEST(PoseEstimation, GuessesTheKindThatWasMeant) {
  const auto error = error_of(kMode, options("6:4", "2:2", "", "heatmap-ofset"), {});
  EXPECT_SAYS(error, "WEIR-1004: option4 is not a kind of heat map");
  EXPECT_SAYS(error, "offered: option4=heatmap-ofset");
  EXPECT_SAYS(error, "needed: one of: heatmap-only, heatmap-offset");
  EXPECT_SAYS(error, "fix: option4=heatmap-offset");
}

TEST(PoseEstimation, GivesTheReasonWhyAKeyPointFileCannotBeUsed) {
  const auto missing = error_of(kMode, options("6:4", "2:2", "/nowhere/points.txt"), {});
  EXPECT_SAYS(missing, "WEIR-4001");
  EXPECT_SAYS(missing, "No such file or directory");
  EXPECT_SAYS(missing, "option3=/nowhere/points.txt");
  EXPECT_SAYS(error_of(kMode, options("6:4", "2:2", body_file("a 1\n")), {}),
              "WEIR-4002: line 1 of the key point file has a connection to a key point that does "
              "not exist");
}

TEST(PoseEstimation, RejectsAnotherNumberOfKeyPoints) {
  const auto fewer = error_of(kMode, options("6:4", "2:2"), {{"17:2:2", std::vector<float>(68)}});
  EXPECT_SAYS(fewer, "WEIR-2001: the heat map has a different number of key points than the body");
  EXPECT_SAYS(fewer, "offered: float32 17:2:2");
  EXPECT_SAYS(fewer, "needed: float32 14:W:H for the default key points, without option3");
  EXPECT_SAYS(fewer, "fix: option3=/path/to/a file of 17 lines");
  const std::string file = body_file("a\nb\nc\n");
  EXPECT_SAYS(error_of(kMode, options("6:4", "2:2", file), {{"2:2:2", std::vector<float>(8)}}),
              "needed: float32 3:W:H for option3=" + file);
}

TEST(PoseEstimation, RejectsWhatIsNoHeatMap) {
  const auto shape =
      error_of(kMode, options("6:4", "2:2"), {{"14:2:2:2", std::vector<float>(112)}});
  EXPECT_SAYS(shape, "WEIR-2001: the first tensor is not a heat map");
  EXPECT_SAYS(shape, "offered: float32 14:2:2:2");
  EXPECT_SAYS(shape, "fix: tensor_filter output-combination=");
  const auto error = error_of(kMode, options("6:4", "2:2"),
                              {{ElementType::UInt8, "14:2:2", std::vector<uint8_t>(56)}});
  EXPECT_SAYS(error, "offered: uint8 14:2:2");
  EXPECT_SAYS(error, "fix: tensor_transform mode=typecast option=float32");
}

TEST(PoseEstimation, RejectsWhatHoldsNoOffsets) {
  const auto with = [](const std::vector<TestTensor>& tensors) {
    return error_of(kMode, options("6:4", "2:2", "", "heatmap-offset"), tensors);
  };
  const TestTensor heat{"14:2:2", std::vector<float>(56)};
  const auto alone = with({heat});
  EXPECT_SAYS(alone, "WEIR-2001: mode=pose_estimation needs more tensors");
  EXPECT_SAYS(alone, "offered: 1 tensor");
  EXPECT_SAYS(alone, "needed: float32 14:W:H, then float32 28:W:H");
  EXPECT_SAYS(alone, "fix: option4=heatmap-only");
  for (const char* shape : {"14:2:2", "27:2:2", "28:3:2", "28:2:3", "28:2:2:2"}) {
    const auto error = with({heat, {shape, {}}});
    EXPECT_SAYS(error, "WEIR-2001: the second tensor does not hold the offsets of the heat map");
    EXPECT_SAYS(error, std::string("offered: float32 ") + shape);
  }
  const auto narrow =
      with({{"14:1:2", std::vector<float>(28)}, {"28:1:2", std::vector<float>(56)}});
  EXPECT_SAYS(narrow, "WEIR-2001: a heat map with offsets has too few cells");
  EXPECT_SAYS(narrow, "at least 2 columns and 2 rows");
}

TEST(PoseEstimation, RejectsFramesThatAreNotWhatTheySay) {
  TestDecoder decoder(kMode, options("6:4", "2:2"));
  decoder.decode({});
  EXPECT_SAYS(decoder.error, "WEIR-2001: mode=pose_estimation needs more tensors");
  EXPECT_SAYS(decoder.error, "offered: 0 tensors");
  decoder.decode({{"14:2:2", std::vector<float>(55)}});
  EXPECT_SAYS(decoder.error, "WEIR-2004");
  EXPECT_SAYS(decoder.error, "offered: 220 bytes");
}

TEST(PoseEstimation, NamesAKeyPointWithoutAFiniteOffset) {
  for (const float odd : {NAN, INFINITY, -INFINITY}) {
    const std::vector<TestTensor> tensors{{"1:2:2", {0, 9, 0, 0}},
                                          {"2:2:2", {0, 0, odd, 0, 0, 0, 0, 0}}};
    const auto error =
        error_of(kMode, options("6:4", "2:2", body_file("nose\n"), "heatmap-offset"), tensors);
    EXPECT_SAYS(error, "WEIR-2001: the key point nose has no position");
    EXPECT_SAYS(error, "with the offsets of cell 1, 0");
    EXPECT_SAYS(error, "needed: offsets that are finite numbers of pixels");
  }
}

TEST(PoseEstimation, TreatsNotANumberAsNoProbability) {
  const std::string file = body_file("a\n");
  Expected expected{20, 20};
  expected.text(10, 10, "a");
  EXPECT_EQ(drawn(options("20:20", "2:2", file), {{"1:2:2", {NAN, 0.1f, 0.2f, 0.8f}}}),
            expected.bytes);
  EXPECT_EQ(drawn(options("20:20", "2:2", file), {{"1:2:2", {NAN, NAN, NAN, NAN}}}),
            Bytes(4 * 400));
}

}  // namespace pose_estimation_test
}  // namespace weir::decoders
