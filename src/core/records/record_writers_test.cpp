// Tests of the text formats of results.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/records/record_writer.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/records/records_test_support.hpp"

namespace weir::records {
namespace record_writers_test {

using Names = std::vector<std::vector<std::string>>;

Labels cats() {
  return Labels(Names{{"cat", "dog \"rex\""}});
}

std::string json(const ResultReader& reader, const TestFrame& frame, const FrameFacts& facts = {},
                 WriterSettings settings = {}) {
  return written(*json_writer(std::move(settings)), reader, frame, facts);
}

TEST(JsonWriter, WritesAFrameAsOneLine) {
  const auto reader = reader_of("x1,y1,x2,y2,score,class,track,parent,rotation,xys:2", "yolo");
  const TestFrame frame = TestFrame().floats(
      "15:1", {10.5f, 20, 30, 40, 0.75f, 1, 7, -1, 0.5f, 11, 21, 0.9f, 12, 22, 0.1f});
  const FrameFacts facts{
      .running_time = 40000000, .unix_time = 1709208000000000000, .width = 640, .height = 480};
  EXPECT_EQ(json(reader, frame, facts, {.labels = cats()}),
            R"({"version":1,"time":0.04,"utc":"2024-02-29T12:00:00Z","source":"yolo",)"
            R"("size":[640,480],"detections":[{"box":[10.5,20,30,40],"score":0.75,"index":1,)"
            R"("label":"dog \"rex\"","track":7,"rotation":0.5,)"
            R"("keypoints":[[11,21,0.9],[12,22,0.1]]}]})"
            "\n");
}

TEST(JsonWriter, LeavesOutWhatIsNotKnown) {
  EXPECT_EQ(json(reader_of(""), TestFrame().floats("4:1", {1, 2, 3, 4})),
            "{\"version\":1,\"detections\":[{\"box\":[1,2,3,4],\"score\":1}]}\n");
  EXPECT_EQ(
      json(reader_of("score,class"), TestFrame().floats("2:1", {0.5f, 9}), {}, {.labels = cats()}),
      "{\"version\":1,\"labels\":[{\"score\":0.5,\"index\":9,\"label\":\"9\"}]}\n");
}

TEST(JsonWriter, AFrameWithoutResultsHasEmptyLists) {
  EXPECT_EQ(json(reader_of("x1,y1,x2,y2,score;score;text"),
                 TestFrame().floats("5:1", {0, 0, 0, 0, 0}).floats("1", {0}).texts(1, {""})),
            "{\"version\":1,\"detections\":[],\"text\":[]}\n");
  EXPECT_EQ(json(reader_of("class-map"), TestFrame().bytes("1", {0})),
            R"({"version":1,"segments":[{"index":0,"label":"0","part":1}]})"
            "\n");
}

TEST(JsonWriter, PartsOfObjectsNameTheDetectionThatTheyBelongTo) {
  // Of three detections the first is background and the second below the threshold.
  const auto reader =
      reader_of(std::string(kBoxes) + ";score,class,parent;score,parent;text", "a;b;c;c");
  const auto frame = TestFrame()
                         .floats("6:3", {0, 0, 0, 0, 0, 0, 1, 1, 5, 5, 0.1f, 0, 2, 2, 8, 8, 1, 0})
                         .floats("3:2", {0.5f, 1, 2, 0.5f, 1, 1})
                         .floats("2:1", {0.75f, 2})
                         .texts(3, {"ab\xFF"});
  const auto out = nlohmann::json::parse(
      json(reader, frame, {}, {.labels = Labels(Names{{"cat"}, {}, {"x"}}), .threshold = 0.4f}));
  const auto expected = nlohmann::json::parse(R"({"version":1,
    "labels":[{"score":0.5,"index":1,"label":"1","parent":0,"source":"b"},
              {"score":0.5,"index":1,"label":"1","source":"b"}],
    "detections":[{"box":[2,2,8,8],"score":1,"index":0,"label":"cat","source":"a"}],
    "text":[{"box":[2,2,8,8],"text":"ab�","score":0.75,"parent":0,"source":"c"}]})");
  EXPECT_EQ(out, expected) << out;
}

TEST(JsonWriter, KeyPointsThatAreNotFiniteKeepTheirPlace) {
  const auto out = nlohmann::json::parse(
      json(reader_of("x1,y1,x2,y2,score,xys:3"),
           TestFrame().floats("14:1", {1, 2, 3, 4, 1, NAN, 1, 1, 5, 6, 1, 1, INFINITY, 1})));
  EXPECT_EQ(out["detections"][0]["keypoints"], nlohmann::json::parse("[null, [5, 6, 1], null]"));
}

TEST(JsonWriter, WritesMasksAndClassesOnRequest) {
  const auto reader = reader_of(std::string(kBoxes) + ";masks;class-map", "m;m;n");
  const auto frame =
      TestFrame().floats("6:1", {1, 1, 2, 2, 1, 0}).bytes("1:1:1", {255}).bytes("1:1", {2});
  const FrameFacts facts{.width = 3, .height = 3};
  EXPECT_EQ(json(reader, frame, facts).find("mask"), std::string::npos);
  const auto out = nlohmann::json::parse(json(reader, frame, facts, {.has_masks = true}));
  EXPECT_EQ(out["detections"][0]["mask"],
            nlohmann::json::parse(R"({"size":[3,3],"counts":"414"})"));
  EXPECT_EQ(
      out["segments"],
      nlohmann::json::parse(
          R"([{"index":2,"label":"2","part":1,"source":"n","mask":{"size":[3,3],"counts":"09"}}])"));
  // Without a picture there is no mask of it; the class map is its own picture.
  const auto alone = nlohmann::json::parse(json(reader, frame, {}, {.has_masks = true}));
  EXPECT_FALSE(alone["detections"][0].contains("mask"));
  EXPECT_EQ(alone["segments"][0]["mask"]["size"], nlohmann::json::parse("[1,1]"));
}

TEST(JsonWriter, MapsComeToPartsAndRanges) {
  const auto frame = TestFrame().bytes("4:1", {1, 1, 0, 1}).floats("2:1", {0.5f, 2});
  EXPECT_EQ(json(reader_of("class-map;depth"), frame, {}, {.labels = cats()}),
            R"({"version":1,"segments":[{"index":0,"label":"cat","part":0.25},)"
            R"({"index":1,"label":"dog \"rex\"","part":0.75}],)"
            R"("depth":[{"least":0.5,"greatest":2,"mean":1.25}]})"
            "\n");
  const auto sources = nlohmann::json::parse(json(reader_of("class-map;depth", "a;b"), frame));
  EXPECT_EQ(sources["segments"][1]["source"], "a");
  EXPECT_EQ(sources["depth"][0]["source"], "b");
}

TEST(RecordWriter, LabelsCanChangeBetweenFrames) {
  const auto writer = json_writer({});
  const auto reader = reader_of("score,class");
  const auto frame = TestFrame().floats("2:1", {0.5f, 1});
  const auto label = [&] {
    return nlohmann::json::parse(written(*writer, reader, frame))["labels"][0]["label"];
  };
  EXPECT_EQ(label(), "1");
  writer->set_labels(cats());
  EXPECT_EQ(label(), "dog \"rex\"");
}

TEST(LabelsOfSources, AreInTheOrderOfTheSources) {
  const LabelsBySource known{{"a", {"cat"}}, {"b", {"red", "blue"}}};
  EXPECT_EQ(labels_of_sources(known, {"b", "x", "a"}), (Names{{"red", "blue"}, {}, {"cat"}}));
  EXPECT_EQ(labels_of_sources(known, {"x", ""}), Names());
}

TEST(WebvttWriter, WritesAHeaderOnceAndACueForEachFrameWithResults) {
  const auto writer =
      webvtt_writer({.labels = Labels(Names{{"cat", "a<b>&c"}}), .threshold = 0.3f});
  const auto reader = reader_of("x1,y1,x2,y2,score,class,track;score;text");
  const auto frame = [](float score, const std::string& text) {
    return TestFrame()
        .floats("7:2", {0, 0, 9, 9, score, 1, 3, 0, 0, 9, 9, 0.2f, 0, 0})
        .floats("1", {score})
        .texts(8, {text});
  };
  EXPECT_EQ(written(*writer, reader, frame(0.914f, "a\nb"),
                    {.running_time = 3723004000000, .duration = 40000000}),
            "WEBVTT\n\n01:02:03.004 --> 01:02:03.044\na&lt;b&gt;&amp;c #3 91 %\na b\n\n");
  EXPECT_EQ(written(*writer, reader, frame(0, "-"), {.running_time = 0}), "(nothing)");
  EXPECT_EQ(written(*writer, reader, frame(1, ""), {}), "(nothing)");  // no time
  EXPECT_EQ(written(*writer, reader, frame(1, " "), {.running_time = 0}),
            "00:00:00.000 --> 00:00:00.040\na&lt;b&gt;&amp;c #3 100 %\n\n");
  writer->restart();
  EXPECT_EQ(written(*writer, reader, frame(0, "-"), {.running_time = 0}), "WEBVTT\n\n");
}

TEST(WebvttWriter, CuesNeverEndBeforeTheyBegin) {
  const auto writer = webvtt_writer({});
  EXPECT_EQ(written(*writer, reader_of("score,class"), TestFrame().floats("2:1", {1, 5}),
                    {.running_time = 1000000, .duration = 1}),
            "WEBVTT\n\n00:00:00.001 --> 00:00:00.002\n5 100 %\n\n");
}

TEST(CocoWriter, WritesAnEntryForEachDetection) {
  const auto writer = coco_writer({.has_coco_ids = true});
  const auto reader = reader_of("x1,y1,x2,y2,score,class,xys:2;masks");
  const auto frame = [](float score) {
    return TestFrame()
        .floats("12:1", {1, 1, 2, 3, score, 79, 5, 6, 0.5f, 7, 8, 0})
        .bytes("1:1:1", {255});
  };
  const FrameFacts facts{.width = 3, .height = 4};
  EXPECT_EQ(written(*writer, reader, frame(0), facts), "(nothing)");
  EXPECT_EQ(written(*writer, reader, frame(0.5f), facts),
            R"({"image_id":1,"category_id":90,"bbox":[1,1,1,2],"score":0.5,)"
            R"("segmentation":{"size":[4,3],"counts":"525"},"keypoints":[5,6,1,0,0,0]})"
            "\n");
  writer->restart();
  EXPECT_EQ(nlohmann::json::parse(written(*writer, reader, frame(0.5f)))["image_id"], 0);
}

TEST(CocoWriter, IdsOfCocoLackTen) {
  // The ids of instances_val2017.json: person 1, stop sign 13, backpack 27, cup 47, toilet 70.
  const std::pair<float, int> ids[] = {{0, 1},   {10, 11}, {11, 13}, {24, 27}, {41, 47},
                                       {61, 70}, {72, 82}, {73, 84}, {79, 90}};
  for (const auto& [index, id] : ids) {
    const auto frame = TestFrame().floats("6:1", {0, 0, 1, 1, 1, index});
    const auto coco = coco_writer({.has_coco_ids = true}), plain = coco_writer({});
    EXPECT_EQ(nlohmann::json::parse(written(*coco, reader_of(kBoxes), frame))["category_id"], id);
    EXPECT_EQ(nlohmann::json::parse(written(*plain, reader_of(kBoxes), frame))["category_id"],
              index);
  }
}

TEST(MotWriter, WritesALineForEachDetectionAndCountsFromOne) {
  const auto writer = mot_writer({.threshold = 0.25f});
  const auto reader = reader_of("x1,y1,x2,y2,score,class,track");
  const auto frame =
      TestFrame().floats("7:3", {0, 0, 10, 20, 0.5f, 0, 12, 1.5f, 2, 3, 4, 1, 2, 0,  //
                                 0, 0, 10, 20, 0.2f, 0, 13});
  EXPECT_EQ(written(*writer, reader, frame), "1,12,1,1,10,20,0.5,1,1\n1,-1,2.5,3,1.5,2,1,3,1\n");
  EXPECT_EQ(written(*writer, reader, TestFrame().floats("7:1", std::vector<float>(7))),
            "(nothing)");
  EXPECT_EQ(written(*writer, reader, frame).substr(0, 4), "3,12");
  writer->restart();
  EXPECT_EQ(written(*writer, reader, frame).substr(0, 4), "1,12");
}

TEST(Writers, NumbersOfAnySizeStayFinite) {
  const float huge = 3e38f;
  for (const auto make : {json_writer, coco_writer, mot_writer, webvtt_writer}) {
    const auto writer = make({});
    const std::string out = written(*writer, reader_of(kBoxes),
                                    TestFrame().floats("6:1", {0, 0, huge, huge, huge, -huge}),
                                    {.running_time = INT64_MAX, .duration = INT64_MAX});
    EXPECT_EQ(out.find("inf"), std::string::npos) << out;
    EXPECT_EQ(out.find("nan"), std::string::npos) << out;
  }
}

}  // namespace record_writers_test
}  // namespace weir::records
