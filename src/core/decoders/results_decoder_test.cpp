// Tests of what the modes that write results have in common, on tensors of YOLOv8.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/decoders/decoders.hpp"

#include "core/decoders/results_test_support.hpp"

namespace weir::decoders {
namespace results_decoder_test {

constexpr size_t kCells = 21;  // of a picture of 32 x 32: 16 + 4 + 1
constexpr size_t kClasses = 3, kValues = 4 + kClasses;

struct Cell {
  size_t index;
  std::vector<float> box;  // centre and size
  std::vector<float> scores;
};

// One output of YOLOv8 for a picture of 32 x 32, values outside.
std::vector<float> head_of(const std::vector<Cell>& cells) {
  std::vector<float> out(kCells * kValues, 0.0f);
  for (const auto& cell : cells) {
    for (size_t i = 0; i < 4; ++i) out[i * kCells + cell.index] = cell.box[i];
    for (size_t i = 0; i < cell.scores.size(); ++i)
      out[(4 + i) * kCells + cell.index] = cell.scores[i];
  }
  return out;
}
TestTensor tensor_of(const std::vector<Cell>& cells) {
  return {"21:7:1", head_of(cells)};
}
const TestModel kModel{.path = "/models/shapes.onnx", .input = "3:32:32:1"};
const std::vector<Cell> kTwo{{3, {16, 8, 4, 6}, {0.1f, 0.9f, 0.2f}},
                             {20, {10, 20, 8, 2}, {0.5f, 0, 0}}};

TEST(ResultsDecoder, WritesTheObjectsOfARecognisedHead) {
  ResultsRun run("detection", {});
  ASSERT_TRUE(run.configure({tensor_of({})}, &kModel)) << run.error;
  EXPECT_EQ(run.caps,
            "other/tensors,format=(string)flexible,weir-columns=(string)"
            "\"x1,y1,x2,y2,score,class,track,parent,rotation\",weir-source=(string)\"shapes\"");
  run.decode({tensor_of(kTwo)});
  ASSERT_EQ(run.results.size(), 1u) << run.error;
  ASSERT_EQ(run.n_rows(), 2u);
  EXPECT_EQ(run.row(0).box(), (Box{14, 5, 18, 11}));
  EXPECT_EQ(run.row(0).class_index(), 1);
  EXPECT_EQ(run.row(0).score(), 0.9f);
  EXPECT_EQ(run.row(0).parent(), -1);
  EXPECT_EQ(run.row(1).box(), (Box{6, 19, 14, 21}));
  EXPECT_EQ(run.row(1).class_index(), 0);
}

TEST(ResultsDecoder, NamesTheSettingsOfAHeadThatIsGivenOthers) {
  ResultsRun run("detection", {{"keypoints", "3"}, {"name", "two shapes"}, {"unit", "pixels"}});
  EXPECT_FALSE(run.configure({tensor_of({})}, &kModel));
  EXPECT_SAYS(run.error, "WEIR-1004: the head yolov8 does not read this setting");
  EXPECT_SAYS(run.error, "offered: custom=keypoints:3");
  EXPECT_SAYS(run.error, "needed: one of: head, input, name, unit");
  EXPECT_SAYS(run.error, "fix: custom='\"head:yolov8,unit:pixels,name:two shapes\"'");
  const ResultsRun without("detection",
                           {{"head", "nanodet"}, {"input", "32:32"}, {"unit", "pixels"}});
  EXPECT_SAYS(without.error, "needed: head, input or name: nanodet has no settings")
      << "before the caps";
  EXPECT_SAYS(without.error, "fix: custom=head:nanodet,input:32:32");
}

TEST(ResultsDecoder, AFileThatIsMissingIsReportedBeforeTheCaps) {
  EXPECT_SAYS(ResultsRun("detection", {{"head", "ssd"}, {"priors", "/nowhere/priors.txt"}}).error,
              "the file of custom=priors cannot be read");
}

TEST(ResultsDecoder, AFrameWithoutObjectsHasOneBackgroundRow) {
  ResultsRun run("detection", {});
  ASSERT_TRUE(run.configure({tensor_of({})}, &kModel));
  run.decode({tensor_of({})});
  ASSERT_EQ(run.n_rows(), 1u);
  EXPECT_TRUE(run.row(0).is_background());
}

TEST(ResultsDecoder, MovesBoxesToTheSourcePicture) {
  SourceMap map;
  map.xx = map.yy = 10, map.x0 = -5, map.y0 = 7;
  map.width = map.height = 32;
  ResultsRun run("detection", {});
  ASSERT_TRUE(run.configure({tensor_of({})}, &kModel));
  run.decode({tensor_of(kTwo)}, {map});
  EXPECT_EQ(run.row(0).box(), (Box{135, 57, 175, 117}));
}

TEST(ResultsDecoder, KeepsWhatTheSettingsSay) {
  const auto rows = [](const DecoderOptions& options) {
    ResultsRun run("detection", options);
    EXPECT_TRUE(run.configure({tensor_of({})}, &kModel)) << run.error;
    run.decode({tensor_of(kTwo)});
    std::vector<int> classes;
    for (size_t i = 0; i < run.n_rows(); ++i)
      if (!run.row(i).is_background()) classes.push_back(run.row(i).class_index());
    return classes;
  };
  EXPECT_EQ(rows({{"threshold", "0.6"}}), (std::vector<int>{1}));
  EXPECT_EQ(rows({{"threshold", "0.95"}}), (std::vector<int>{}));
  EXPECT_EQ(rows({{"max-results", "1"}}), (std::vector<int>{1}));
  EXPECT_EQ(rows({{"classes", "0,2"}}), (std::vector<int>{0}));
  const auto labels = file_with("answer-labels.txt", "disc\nsquare\nstar\n");
  EXPECT_EQ(rows({{"labels", labels}, {"classes", "square"}}), (std::vector<int>{1}));
}

TEST(ResultsDecoder, ClassesMayBeLabelsOfTheModel) {
  const TestModel named{.metadata = R"({"names": "{0: 'disc', 1: \"square\", 2: 'star'}"})",
                        .input = "3:32:32:1"};
  ResultsRun run("detection", {{"classes", "disc"}});
  ASSERT_TRUE(run.configure({tensor_of({})}, &named)) << run.error;
  run.decode({tensor_of(kTwo)});
  ASSERT_EQ(run.n_rows(), 1u);
  EXPECT_EQ(run.row(0).class_index(), 0);
}

TEST(ResultsDecoder, ReadsQuantisedOutputs) {
  // real = 0.5 * (value - 10).
  std::vector<uint8_t> values;
  for (const float value : head_of({{3, {16, 8, 4, 6}, {0, 1, 0}}}))
    values.push_back(static_cast<uint8_t>(value / 0.5f + 10));
  const TestTensor tensor(ElementType::UInt8, "21:7:1", values);
  const TestModel model{.input = "3:32:32:1", .scales = {0.5f}, .zero_points = {10}};
  ResultsRun run("detection", {});
  ASSERT_TRUE(run.configure({tensor}, &model)) << run.error;
  run.decode({tensor});
  ASSERT_EQ(run.n_rows(), 1u) << run.error;
  EXPECT_EQ(run.row(0).box(), (Box{14, 5, 18, 11}));
  EXPECT_EQ(run.row(0).score(), 1);
}

// Reads a batch of two regions of 32 x 32; the second lies `distance` to the right of the first.
void read_regions(ResultsRun& run, const std::vector<Cell>& first, const std::vector<Cell>& second,
                  SourceMap map, double distance) {
  std::vector<float> both = head_of(first), more = head_of(second);
  both.insert(both.end(), more.begin(), more.end());
  const TestTensor batch("21:7:2", both);
  map.width = map.height = 32;
  SourceMap moved = map;
  moved.x0 = distance;
  if (map.row > 0) ++moved.row;
  ASSERT_TRUE(run.configure({batch}, &kModel, true)) << run.error;
  run.decode({batch}, {map, moved}, true);
  ASSERT_EQ(run.results.size(), 1u) << run.error;
}

TEST(ResultsDecoder, RegionsOfABatchAreParents) {
  ResultsRun run("detection", {});
  SourceMap map;
  map.row = 1;
  read_regions(run, {}, kTwo, map, 100);
  ASSERT_EQ(run.n_rows(), 2u);
  EXPECT_EQ(run.row(0).parent(), 1);
  EXPECT_EQ(run.row(0).box(), (Box{114, 5, 118, 11}));
}

TEST(ResultsDecoder, RegionsThatAreNoGridAreParents) {
  ResultsRun run("detection", {});
  SourceMap map;
  map.source_width = 640, map.source_height = 480;
  read_regions(run, {}, kTwo, map, 100);
  ASSERT_EQ(run.n_rows(), 2u);
  EXPECT_EQ(run.row(0).parent(), 1);
  EXPECT_EQ(run.row(1).parent(), 1);
}

TEST(ResultsDecoder, RegionsWithoutRowsAreTilesOfThePicture) {
  ResultsRun run("detection", {});
  SourceMap map;
  map.source_width = 44, map.source_height = 32;
  // The first object again, 12 pixels further left; and one that only the second tile has.
  read_regions(run, kTwo, {{3, {4, 8, 4, 6}, {0, 0.8f, 0}}, {18, {20, 25, 4, 4}, {0, 0.6f, 0}}},
               map, 12);
  ASSERT_EQ(run.n_rows(), 3u);
  EXPECT_EQ(run.row(0).box(), (Box{14, 5, 18, 11}));
  EXPECT_EQ(run.row(1).box(), (Box{30, 23, 34, 27}));
  for (size_t i = 0; i < 3; ++i) EXPECT_EQ(run.row(i).parent(), -1) << "there are no rows of tiles";
}

TEST(ResultsDecoder, NumbersThatAreNotFiniteGiveNoObjects) {
  ResultsRun run("detection", {});
  ASSERT_TRUE(run.configure({tensor_of({})}, &kModel));
  run.decode({TestTensor("21:7:1", std::vector<float>(kCells * kValues, NAN))});
  ASSERT_EQ(run.n_rows(), 1u) << run.error;
  EXPECT_TRUE(run.row(0).is_background());
  run.decode({TestTensor("21:7:1", std::vector<float>(kCells * kValues, INFINITY))});
  ASSERT_EQ(run.n_rows(), 1u) << run.error;
  EXPECT_TRUE(run.row(0).is_background());
}

TEST(ResultsDecoder, RefusesOptionsThatCannotBeUsed) {
  const auto error = [](const char* key, const char* value) {
    return ResultsRun("detection", {{key, value}}).error;
  };
  for (const char* value : {"1.5", "-1", "nan", "a", "0.5x"}) {
    EXPECT_SAYS(error("threshold", value), std::string("offered: threshold=") + value);
    EXPECT_SAYS(error("threshold", value), "a number from 0 to 1");
    EXPECT_SAYS(error("iou", value), std::string("offered: iou=") + value);
  }
  for (const char* value : {"0", "-1", "65537", "many"})
    EXPECT_SAYS(error("max-results", value), "a whole number from 1 to 65536");
  EXPECT_SAYS(error("labels", "/nowhere/labels.txt"), "labels=/nowhere/labels.txt");
  EXPECT_SAYS(error("head", "hourglass"), "this mode has no such head");
  EXPECT_SAYS(error("head", "yolov"), "did you mean yolov");
  EXPECT_SAYS(error("input", "640"), "input=640");
}

TEST(ResultsDecoder, RefusesClassesWithoutLabel) {
  ResultsRun run("detection", {{"classes", "cat"}});
  EXPECT_FALSE(run.configure({tensor_of({})}, &kModel));
  EXPECT_SAYS(run.error, "classes=cat");
  EXPECT_SAYS(run.error, "labels=FILE");
}

TEST(ResultsDecoder, NamesTheHeadsWhereNoneFits) {
  ResultsRun run("detection", {});
  EXPECT_FALSE(run.configure({TestTensor("3:3", std::vector<float>(9))}, &kModel));
  EXPECT_SAYS(run.error, "no head of this mode fits these outputs");
  EXPECT_SAYS(run.error, "float32 3:3");
  EXPECT_SAYS(run.error, "the outputs of a head of docs/heads.md: ");
  EXPECT_SAYS(run.error, "rtdetr and 18 others");
}

TEST(ResultsDecoder, AFlexibleStreamNeedsAKnownModel) {
  ResultsRun run("detection", {});
  EXPECT_FALSE(run.configure({}, nullptr, true));
  EXPECT_SAYS(run.error, "a flexible stream that does not come from tensor_filter");
}

TEST(ResultsDecoder, RefusesABatchOfFewerPartsThanRegions) {
  ResultsRun run("detection", {});
  ASSERT_TRUE(run.configure({tensor_of({})}, &kModel));
  run.decode({tensor_of({})}, {SourceMap(), SourceMap()}, true);
  EXPECT_SAYS(run.error, "2 in the outermost dimension");
}

}  // namespace results_decoder_test
}  // namespace weir::decoders
