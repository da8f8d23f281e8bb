// Tests that lines of mode=json are valid by docs/schema/results-1.schema.json, for frames of any
// content.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <regex>

#include "core/records/records_test_support.hpp"

namespace weir::records {
namespace {

using Json = nlohmann::json;

// The keywords of JSON Schema that the schema uses. Members that it does not name are an error
// here: they are not documented.
class Schema {
 public:
  explicit Schema(Json schema) : root_(std::move(schema)) {}
  // The first violation; "" if there is none.
  std::string check(const Json& value) const { return check(root_, value, "#"); }

 private:
  static bool is_of(const std::string& type, const Json& value) {
    if (type == "object") return value.is_object();
    if (type == "array") return value.is_array();
    if (type == "string") return value.is_string();
    if (type == "integer") return value.is_number_integer();
    if (type == "number") return value.is_number();
    return type == "null" && value.is_null();
  }

  std::string check(const Json& schema, const Json& value, const std::string& at) const {
    if (schema.contains("$ref")) {
      const std::string name = schema["$ref"].get<std::string>().substr(strlen("#/$defs/"));
      return check(root_["$defs"].at(name), value, at);
    }
    if (schema.contains("const") && value != schema["const"]) return at + ": const";
    if (schema.contains("type")) {
      const Json types = schema["type"].is_array() ? schema["type"] : Json::array({schema["type"]});
      bool fits = false;
      for (const auto& type : types) fits |= is_of(type, value);
      if (!fits) return at + ": type of " + value.dump();
    }
    if (value.is_number()) {
      const double number = value.get<double>();
      if (schema.contains("minimum") && number < schema["minimum"].get<double>())
        return at + ": minimum";
      if (schema.contains("exclusiveMinimum") &&
          !(number > schema["exclusiveMinimum"].get<double>()))
        return at + ": exclusiveMinimum";
    }
    if (schema.contains("pattern") &&
        !std::regex_search(value.get<std::string>(), std::regex(schema["pattern"])))
      return at + ": pattern";
    if (value.is_array()) return check_array(schema, value, at);
    return value.is_object() ? check_object(schema, value, at) : "";
  }
  std::string check_array(const Json& schema, const Json& value, const std::string& at) const {
    if (schema.contains("minItems") && value.size() < schema["minItems"]) return at + ": minItems";
    if (schema.contains("maxItems") && value.size() > schema["maxItems"]) return at + ": maxItems";
    for (size_t i = 0; i < value.size(); ++i)
      if (auto wrong = check(schema.at("items"), value[i], at + "/" + std::to_string(i));
          !wrong.empty())
        return wrong;
    return "";
  }
  std::string check_object(const Json& schema, const Json& value, const std::string& at) const {
    for (const auto& name : schema.value("required", Json::array()))
      if (!value.contains(name.get<std::string>())) return at + ": lacks " + name.dump();
    for (const auto& [name, member] : value.items()) {
      if (!schema.at("properties").contains(name)) return at + ": unknown member " + name;
      if (auto wrong = check(schema["properties"][name], member, at + "/" + name); !wrong.empty())
        return wrong;
    }
    return "";
  }

  const Json root_;
};

class JsonSchema : public testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("WEIR_TEST_SCHEMAS");
    if (!folder) GTEST_SKIP() << "WEIR_TEST_SCHEMAS is not set: run the test by meson";
    std::ifstream file(std::string(folder) + "/results-1.schema.json");
    ASSERT_TRUE(file);
    schema = std::make_unique<Schema>(Json::parse(file));
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

}  // namespace
}  // namespace weir::records
