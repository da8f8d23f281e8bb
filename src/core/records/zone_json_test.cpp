// Tests of the members about zones in lines of mode=json.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>

#include "core/records/records_test_support.hpp"

namespace weir::records {
namespace zone_json_test {

// Rows of one detector, with two zones for each object, and the tables of zones.
const std::string kColumns = with_zone_columns("x1,y1,x2,y2,score,class,track", 2) + ";" +
                             kZoneCountColumns + ";" + kZoneEventColumns;

std::string json(const TestFrame& frame,
                 std::vector<std::string> zones = {"yard", "the \"gate\""}) {
  const auto reader = reader_of(kColumns, "yolo;zones;zones");
  return written(
      *json_writer({.labels = Labels(std::vector<std::vector<std::string>>{{"person", "car"}}),
                    .zones = std::move(zones)}),
      reader, frame);
}
const std::vector<float> kNoCounts(10), kNoEvents(8);

TEST(ZoneJson, ObjectsHaveTheirZonesAndSpeeds) {
  const auto frame = TestFrame()
                         .floats("13:3", {1, 2, 3, 4, 1, 0, 7, 12.5f, 1.25f, 1, 2, 0.5f, 0,  //
                                          1, 2, 3, 4, 1, 1, 8, NAN,   NAN,   0, 0, 0,    0,  //
                                          1, 2, 3, 4, 1, 1, 0, 0,     NAN,   3, 0, NAN,  0})
                         .floats("10:1", kNoCounts)
                         .floats("8:1", kNoEvents);
  EXPECT_EQ(
      json(frame),
      R"({"version":1,"source":"yolo","detections":[)"
      R"({"box":[1,2,3,4],"score":1,"index":0,"label":"person","track":7,"speed":12.5,)"
      R"("ground_speed":1.25,"zones":[{"name":"yard","dwell":0.5},{"name":"the \"gate\"","dwell":0}]},)"
      R"({"box":[1,2,3,4],"score":1,"index":1,"label":"car","track":8},)"
      R"({"box":[1,2,3,4],"score":1,"index":1,"label":"car","speed":0,"zones":[{"name":"3"}]}],)"
      R"("zones":[],"events":[]})"
      "\n");
}

TEST(ZoneJson, FramesHaveCountsOfEachZoneAndClass) {
  const auto frame =
      TestFrame()
          .floats("13:1", std::vector<float>(13))
          .floats("10:4", {0,  1,    -1,  2,   5,   3,   NAN, NAN, 10, 0.5f, 0,   1,  0,   1,
                           2,  1,    NAN, NAN, NAN, NAN, 0,   1,   1,  1,    3,   2,  NAN, NAN,
                           10, 0.5f, 0,   2,   -1,  NAN, NAN, NAN, 4,  1,    NAN, NAN})
          .floats("8:1", kNoEvents);
  EXPECT_EQ(
      json(frame),
      R"({"version":1,"source":"yolo","detections":[],"zones":[)"
      R"({"name":"yard","inside":2,"entered":5,"left":3,"speed":10,"ground_speed":0.5,"classes":[)"
      R"({"index":0,"label":"person","inside":1,"entered":2,"left":1},)"
      R"({"index":1,"label":"car","inside":1,"entered":3,"left":2,"speed":10,"ground_speed":0.5}]},)"
      R"({"name":"the \"gate\"","forward":4,"backward":1,"classes":[]}],"events":[]})"
      "\n");
}

TEST(ZoneJson, FramesHaveEvents) {
  const auto frame = TestFrame()
                         .floats("13:1", std::vector<float>(13))
                         .floats("10:1", kNoCounts)
                         .floats("8:3", {0, 1, 1, 0,  7, NAN,  NAN, NAN,   //
                                         0, 2, 5, -1, 8, NAN,  3,   0.5f,  //
                                         0, 1, 2, 1,  9, 2.5f, NAN, NAN});
  EXPECT_EQ(json(frame, {}),
            R"({"version":1,"source":"yolo","detections":[],"zones":[],"events":[)"
            R"({"event":"enter","zone":"1","track":7,"index":0,"label":"person"},)"
            R"({"event":"backward","zone":"2","track":8,"speed":3,"ground_speed":0.5},)"
            R"({"event":"leave","zone":"1","track":9,"index":1,"label":"car","dwell":2.5}]})"
            "\n");
}

TEST(ZoneJson, NumbersThatMeanNothingAreLeftOut) {
  const auto frame =
      TestFrame()
          .floats("13:1", {1, 2, 3, 4, 1, 0, 7, INFINITY, -INFINITY, -3, NAN, 1, 1})
          .floats("10:2", {0, NAN, 0, 1, 1, 1, 1, 1, 1, 1, 0, 1, NAN, -5, 3e38f, 1, 1, 1, 1, 1})
          .floats("8:3",
                  {0, 1, 6, 0, 7, 0, 0, 0, 0, 1, NAN, 0, 7, 0, 0, 0, 0, 9e9f, 1, 0, 7, 0, 0, 0});
  const std::string line = json(frame);
  EXPECT_SAYS(line, R"("track":7}],"zones":[{"name":"yard",)");
  EXPECT_SAYS(line, R"("events":[])");
  EXPECT_LACKS(line, "entered");
}

TEST(ZoneJson, TablesOfAnotherShapeAreRejected) {
  const auto reader = reader_of(kColumns, "yolo;zones;zones");
  ResultFrame out;
  const auto error = [&](const TestFrame& frame) {
    const auto status = reader.read(frame.tensors, &out);
    return status ? "" : status.error().message();
  };
  EXPECT_SAYS(error(TestFrame()
                        .floats("13:1", std::vector<float>(13))
                        .floats("9:1", std::vector<float>(9))
                        .floats("8:1", kNoEvents)),
              "needed: float32 10:N, rows of the columns");
  EXPECT_SAYS(error(TestFrame().floats("13:1", std::vector<float>(13)).floats("10:1", kNoCounts)),
              "fewer tensors than weir-columns names");
}

TEST(ZoneJson, ZonesOfTwoElementsAreRejected) {
  const auto reader = ResultReader::make(kColumns + ";" + kZoneCountColumns, "yolo;a;a;b");
  ASSERT_FALSE(reader);
  EXPECT_SAYS(reader.error().message(),
              "WEIR-1001: the results have zones of more than one tensor_zones");
}

TEST(ZoneJson, OtherReadersSkipTheTables) {
  // Columns of their own: the rows of the tables have the score 0.
  for (const char* columns : {kZoneCountColumns, kZoneEventColumns}) {
    weir_result_columns parsed;
    ASSERT_TRUE(weir_results_parse(columns, 0, &parsed));
    EXPECT_EQ(parsed.score, 0);
    EXPECT_EQ(parsed.box, -1);
  }
}

}  // namespace zone_json_test
}  // namespace weir::records
