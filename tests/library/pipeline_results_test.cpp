// Tests what frames of pipeline.hpp say about their tensors: results, labels, source maps; and
// properties as JSON.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <fstream>

#include "pipeline_test_support.hpp"
#include "says.hpp"
#include "weir/pipeline.hpp"
#include "weir/results.hpp"

namespace pipeline_results_test {

using namespace weir::pipeline_test;
using weir::Code;
using weir::Frame;
using weir::Pipeline;
using Values = std::vector<float>;

Frame pull_frame(Pipeline& pipeline) {
  auto frame = pipeline.pull("out", kLong);
  if (!frame) throw std::runtime_error(frame.error().message());
  if (!*frame) throw std::runtime_error("no frame came");
  return **frame;
}

// A decoder of rows x1, y1, x2, y2, score, class.
std::string decoder(const std::string& name, const std::string& labels) {
  const std::string path = testing::TempDir() + name + ".labels";
  std::ofstream(path) << labels;
  return "tensor_decoder mode=detection custom=head:yolov10,input:100:100,name:" + name +
         " labels=" + path;
}

constexpr float kRowsOfOne[] = {10, 20, 30, 40, 0.9F, 1};
constexpr std::span<const float> kRows(kRowsOfOne);

TEST(Frame, NamesClassesByTheLabelsOfItsStream) {
  Pipeline p =
      started("appsrc name=in ! " + decoder("net", "cat\ndog\n") + " ! tensor_sink name=out");
  ASSERT_TRUE(p.push("in", kRows, {.shape = {1, 1, 6}}));
  const Frame frame = pull_frame(p);
  EXPECT_EQ(frame.caps_field(WEIR_RESULTS_SOURCE), "net");
  const auto columns = weir::result_columns(frame.caps_field(WEIR_RESULTS_COLUMNS), 0);
  ASSERT_TRUE(columns);
  const auto numbers = *frame[0].as<float>();
  const weir::ResultRow row(*columns, numbers.data());
  EXPECT_EQ(row.box().x2, 30);
  EXPECT_EQ(frame.label(0, row.class_index()), "dog");
  EXPECT_EQ(frame.label(0, 0), "cat");
  ASSERT_TRUE(p.stop());
  EXPECT_EQ(frame.label(0, 1), "dog") << "the frame outlives the stream";
}

TEST(Frame, HasNoLabelsThatItsStreamDoesNotName) {
  Pipeline p =
      started("appsrc name=in ! " + decoder("two", "cat\ndog\n") + " ! tensor_sink name=out");
  ASSERT_TRUE(p.push("in", kRows, {.shape = {1, 1, 6}}));
  const Frame frame = pull_frame(p);
  EXPECT_EQ(frame.label(0, 2), "");
  EXPECT_EQ(frame.label(0, -1), "");
  EXPECT_EQ(frame.label(1, 0), "");
  EXPECT_EQ(frame.label(9, 0), "");
  EXPECT_EQ(frame.caps_field("no-such-field"), "");
  EXPECT_EQ(frame.caps_field("framerate"), "") << "not a text";
}

TEST(Frame, KeepsTheLabelsOfEachSource) {
  Pipeline p = started("tensor_mux name=m ! tensor_sink name=out appsrc name=a ! " +
                       decoder("pets", "cat\ndog\n") + " ! m. appsrc name=b ! " +
                       decoder("food", "pear\nplum\n") + " ! m.");
  ASSERT_TRUE(p.push("a", kRows, {.shape = {1, 1, 6}, .pts = weir::Nanoseconds(0)}));
  ASSERT_TRUE(p.push("b", kRows, {.shape = {1, 1, 6}, .pts = weir::Nanoseconds(0)}));
  const Frame frame = pull_frame(p);
  ASSERT_EQ(frame.size(), 2u);
  EXPECT_EQ(frame.caps_field(WEIR_RESULTS_SOURCE), "pets;food");
  EXPECT_EQ(frame.label(0, 1), "dog");
  EXPECT_EQ(frame.label(1, 1), "plum");
}

TEST(Frame, OfOtherTensorsHasNeitherLabelsNorMaps) {
  Pipeline p = started("appsrc name=in ! tensor_sink name=out");
  ASSERT_TRUE(p.push("in", kRows, {.shape = {6}}));
  const Frame frame = pull_frame(p);
  EXPECT_EQ(frame.caps_field(WEIR_RESULTS_COLUMNS), "");
  EXPECT_EQ(frame.label(0, 0), "");
  EXPECT_TRUE(frame.source_maps().empty());
}

TEST(Frame, HasTheSourceMapOfItsPicture) {
  Pipeline p = started(
      "videotestsrc num-buffers=1 ! video/x-raw,format=RGB,width=640,height=480 ! "
      "tensor_preprocess width=32 height=16 ! tensor_sink name=out");
  const auto maps = pull_frame(p).source_maps();
  ASSERT_EQ(maps.size(), 1u);
  EXPECT_EQ(maps[0].source_width, 640u);
  EXPECT_EQ(maps[0].height, 16u);
  const auto corner = maps[0].to_source({32, 16});
  EXPECT_DOUBLE_EQ(corner.x, 640);
  EXPECT_DOUBLE_EQ(corner.y, 480);
  weir_source_map map{};
  EXPECT_EQ(weir_pulled_map(nullptr, 0, &map), -WEIR_OPTION_VALUE);
}

TEST(Pipeline, ReturnsPropertiesAsJson) {
  Pipeline p = started("appsrc name=in ! valve name=v ! tensor_sink name=out");
  ASSERT_TRUE(p.push("in", kRows, {.shape = {6}}));
  pull_frame(p);
  EXPECT_NE(p.get_json("out", "stats")->find("\"received\":1,"), std::string::npos);
  EXPECT_EQ(*p.get_json("v", "drop"), "false");
  EXPECT_EQ(*p.get_json("v", "drop-mode"), "\"drop-all\"");
  EXPECT_EQ(*p.get_json("v", "name"), "\"v\"");
  EXPECT_EQ(*p.get_json("in", "max-buffers"), "0");
  const auto missing = p.get_json("v", "stat");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, Code::OPTION_VALUE);
  EXPECT_SAYS(missing.error().message(), "valve has no such property");
  EXPECT_EQ(p.get_json("w", "drop").error().code, Code::OPTION_VALUE);
}

TEST(Pipeline, ListsItsElementsByName) {
  Pipeline p = started("appsrc name=in ! valve name=v ! tensor_sink name=out");
  const auto elements = p.elements();
  ASSERT_TRUE(elements);
  const std::vector<std::pair<std::string, std::string>> wanted{
      {"in", "appsrc"}, {"v", "valve"}, {"out", "tensor_sink"}};
  EXPECT_EQ(*elements, wanted);
}

}  // namespace pipeline_results_test
