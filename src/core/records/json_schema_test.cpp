// Tests that lines of mode=json are valid by docs/schema/results-1.schema.json, for frames of any
// content.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>
#include <random>

#include "core/records/json_schema_test_support.hpp"
#include "core/records/records_test_support.hpp"

namespace weir::records {
namespace json_schema_test {

using test::Schema;
using Json = nlohmann::json;

class JsonSchema : public testing::Test {
 protected:
  void SetUp() override {
    schema = Schema::from_file("results-1.schema.json");
    if (!schema) GTEST_SKIP() << "WEIR_TEST_SCHEMAS is not set: run the test by meson";
  }
  std::unique_ptr<Schema> schema;
};

TEST_F(JsonSchema, RefusesWhatItDoesNotDescribe) {
  for (const char* text :
       {R"({})", R"({"version":2})", R"({"version":1,"time":"0"})", R"({"version":1,"size":[1]})",
        R"({"version":1,"size":[1.5,2]})", R"({"version":1,"utc":"2024-02-29 12:00:00"})",
        R"({"version":1,"detections":[{"score":1}]})", R"({"version":1,"labels":[{"score":0}]})",
        R"({"version":1,"detections":[{"box":[1,2,3],"score":1}]})",
        R"({"version":1,"detections":[{"box":[1,2,3,4],"score":1,"parent":-1}]})",
        R"({"version":1,"detections":[{"box":[1,2,3,4],"score":1,"keypoints":[[1,2]]}]})",
        R"({"version":1,"text":[{"score":1}]})", R"({"version":1,"other":1})"})
    EXPECT_NE(schema->check(Json::parse(text)), "") << text;
  EXPECT_EQ(schema->check(Json::parse(R"({"version":1})")), "");
}

TEST_F(JsonSchema, LinesOfAnyFrameAreValid) {
  std::mt19937 random(11);
  const float special[] = {0, -0.0f, 1, 0.5f, -1, 3e38f, -3e38f, 1e-40f, NAN, INFINITY, 7, 100};
  const auto numbers = [&](size_t count) {
    std::vector<float> out(count);
    for (auto& number : out) number = special[random() % std::size(special)];
    return out;
  };
  const auto bytes = [&](size_t count) {
    std::vector<uint8_t> out(count);
    for (auto& byte : out) byte = static_cast<uint8_t>(random());
    return out;
  };
  const auto reader = reader_of(
      "x1,y1,x2,y2,score,class,track,parent,rotation,xys:2;masks;score,class,parent;"
      "x1,y1,x2,y2,score,parent;text;class-map",
      "a;a;b;c;c;d");
  size_t detections = 0;
  for (int i = 0; i < 300; ++i) {
    const TestFrame frame = TestFrame()
                                .floats("15:3", numbers(45))
                                .bytes("2:3:3", bytes(18))
                                .floats("3:2", numbers(6))
                                .floats("6:2", numbers(12))
                                .bytes("5:2", bytes(10))
                                .bytes("3:2", bytes(6));
    const FrameFacts facts{.running_time = static_cast<int64_t>(random()) - 1,
                           .unix_time = static_cast<int64_t>(random()) - 1,
                           .width = static_cast<uint32_t>(random() % 40),
                           .height = static_cast<uint32_t>(random() % 40)};
    const auto writer = json_writer({.has_masks = random() % 2 == 0});
    const std::string line = written(*writer, reader, frame, facts);
    ASSERT_EQ(line.find('\n'), line.size() - 1);
    const Json json = Json::parse(line);
    EXPECT_EQ(schema->check(json), "") << line;
    detections += json["detections"].size();
  }
  EXPECT_GT(detections, 30u);
}

TEST_F(JsonSchema, LinesWithZonesAreValid) {
  std::mt19937 random(12);
  const float special[] = {0, 1, 2, 3, 0.5f, -1, 3e38f, NAN, INFINITY};
  const auto numbers = [&](size_t count) {
    std::vector<float> out(count);
    for (auto& number : out) number = special[random() % std::size(special)];
    return out;
  };
  const auto reader = reader_of(with_zone_columns("x1,y1,x2,y2,score,class", 2) + ";" +
                                    kZoneCountColumns + ";" + kZoneEventColumns,
                                "a;z;z");
  size_t zones = 0, events = 0, of_objects = 0;
  for (int i = 0; i < 300; ++i) {
    const TestFrame frame = TestFrame()
                                .floats("12:3", numbers(36))
                                .floats("10:3", numbers(30))
                                .floats("8:3", numbers(24));
    const std::string line = written(*json_writer({.zones = {"a"}}), reader, frame);
    const Json json = Json::parse(line);
    EXPECT_EQ(schema->check(json), "") << line;
    zones += json["zones"].size();
    events += json["events"].size();
    for (const auto& object : json["detections"]) of_objects += object.contains("zones");
  }
  EXPECT_GT(zones, 30u);
  EXPECT_GT(events, 30u);
  EXPECT_GT(of_objects, 30u);
}

}  // namespace json_schema_test
}  // namespace weir::records
