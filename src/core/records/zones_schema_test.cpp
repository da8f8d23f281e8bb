// Tests that docs/schema/zones-1.schema.json accepts and refuses the zones files that the parser
// accepts and refuses.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include "core/records/json_schema_test_support.hpp"
#include "core/zone/zone_file.hpp"

namespace weir::records {
namespace zones_schema_test {

using Json = nlohmann::json;

enum class Verdict { Accepted, Refused };

// A file with all members, each with a value that may stand there.
Json whole_file() {
  return Json::parse(R"({
    "$schema": "zones-1.schema.json", "comment": "a yard", "version": 1,
    "zones": [
      {"name": "yard", "polygon": [[0, 0], [10, 0], [10, 10]], "reference": "top", "dwell": 3,
       "margin": 0.5, "comment": 1},
      {"name": "gate", "line": [[1, 2], [3, 4]], "reference": "centre", "margin": 0}],
    "ground": {"picture": [[0, 100], [100, 100], [75, 50], [25, 50]],
               "metres": [[0, 0], [4, 0], [4, 10], [0, 10]], "comment": []}})");
}

class ZonesSchema : public testing::Test {
 protected:
  void SetUp() override {
    schema = test::Schema::from_file("zones-1.schema.json");
    if (!schema) GTEST_SKIP() << "WEIR_TEST_SCHEMAS is not set: run the test by meson";
  }
  void expect(Verdict wanted, const Json& file) const {
    const auto parsed = zone::parse_zones(file.dump(), "z.json");
    const std::string violation = schema->check(file);
    EXPECT_EQ(wanted == Verdict::Accepted, static_cast<bool>(parsed))
        << file.dump().substr(0, 400) << (parsed ? "" : parsed.error().message());
    EXPECT_EQ(wanted == Verdict::Accepted, violation.empty()) << file.dump().substr(0, 400) << "\n"
                                                              << violation;
  }
  // The whole file with another value at this JSON Pointer.
  void expect(Verdict wanted, const char* at, const Json& value) const {
    Json file = whole_file();
    file[Json::json_pointer(at)] = value;
    expect(wanted, file);
  }
  std::unique_ptr<test::Schema> schema;
};

TEST_F(ZonesSchema, AcceptsTheWholeFileAndOneWithoutWhatMayBeMissing) {
  expect(Verdict::Accepted, whole_file());
  for (const char* at :
       {"/$schema", "/comment", "/ground", "/zones/0/reference", "/zones/0/dwell",
        "/zones/0/margin", "/zones/0/comment", "/zones/1/margin", "/ground/comment"})
    expect(Verdict::Accepted, whole_file().patch(Json::array({{{"op", "remove"}, {"path", at}}})));
}

TEST_F(ZonesSchema, RefusesAFileWithoutWhatMustBeThere) {
  for (const char* at : {"/version", "/zones", "/zones/0/name", "/zones/0/polygon", "/zones/1/line",
                         "/ground/picture", "/ground/metres"})
    expect(Verdict::Refused, whole_file().patch(Json::array({{{"op", "remove"}, {"path", at}}})));
}

TEST_F(ZonesSchema, RefusesMembersThatAreNotKnown) {
  for (const char* at : {"/colour", "/zones/0/colour", "/zones/0/$schema", "/ground/colour"})
    expect(Verdict::Refused, at, "red");
}

TEST_F(ZonesSchema, EachMemberHasItsTypes) {
  const Json values[] = {nullptr, true, 1, 0.5, "text", Json::array(), Json::object()};
  const auto name_of = [](const Json& value) { return std::string(value.type_name()); };
  const std::pair<const char*, const char*> members[] = {{"/version", "1"},
                                                         {"/zones", "array"},
                                                         {"/ground", ""},
                                                         {"/zones/0", ""},
                                                         {"/zones/0/name", "string"},
                                                         {"/zones/0/polygon", ""},
                                                         {"/zones/1/line", ""},
                                                         {"/zones/0/dwell", "number"},
                                                         {"/zones/0/margin", "number"},
                                                         {"/zones/1/margin", "number"},
                                                         {"/zones/0/reference", ""},
                                                         {"/ground/picture", ""},
                                                         {"/ground/metres", ""},
                                                         {"/zones/0/polygon/1", ""},
                                                         {"/zones/0/polygon/1/0", "number"},
                                                         {"/ground/metres/0/1", "number"}};
  for (const auto& [at, type] : members)
    for (const Json& value : values)
      expect(name_of(value) == type || value.dump() == type ? Verdict::Accepted : Verdict::Refused,
             at, value);
  for (const char* at : {"/comment", "/$schema", "/zones/0/comment", "/ground/comment"})
    for (const Json& value : values) expect(Verdict::Accepted, at, value);
}

TEST_F(ZonesSchema, HasTheLimitsOfTheParser) {
  const auto accepted = [this](const char* at, const Json& value) {
    expect(Verdict::Accepted, at, value);
  };
  const auto refused = [this](const char* at, const Json& value) {
    expect(Verdict::Refused, at, value);
  };
  accepted("/version", 1.0), refused("/version", 2), refused("/version", 0);
  accepted("/zones/0/name", std::string(256, 'n')), refused("/zones/0/name", std::string(257, 'n'));
  refused("/zones/0/name", ""), refused("/zones/0/name", std::string("a\0b", 3));
  accepted("/zones/0/dwell", 1e6), refused("/zones/0/dwell", 1000001);
  accepted("/zones/0/dwell", 1e-9), refused("/zones/0/dwell", 0), refused("/zones/0/dwell", -1);
  for (const char* margin : {"/zones/0/margin", "/zones/1/margin"}) {
    accepted(margin, 0), accepted(margin, 10);
    refused(margin, 10.001), refused(margin, -0.001);
  }
  for (const char* number : {"/zones/0/polygon/2/1", "/zones/1/line/0/0"}) {
    accepted(number, 1e6), accepted(number, -1e6);
    refused(number, 1000000.5), refused(number, -1000000.5);
  }
  for (const char* reference : {"bottom", "centre", "top"})
    accepted("/zones/1/reference", reference);
  refused("/zones/1/reference", "center"), refused("/zones/1/reference", "Top");
}

TEST_F(ZonesSchema, HasTheNumbersOfPointsOfTheParser) {
  const auto points = [](int count) {
    Json out = Json::array();
    for (int i = 0; i < count; ++i) out.push_back({i, i * i});
    return out;
  };
  for (const int count : {0, 1, 2, 3, 4, 1000, 1001}) {
    expect(count >= 3 && count <= 1000 ? Verdict::Accepted : Verdict::Refused, "/zones/0/polygon",
           points(count));
    expect(count == 2 ? Verdict::Accepted : Verdict::Refused, "/zones/1/line", points(count));
    expect(count == 4 ? Verdict::Accepted : Verdict::Refused, "/ground/metres", points(count));
  }
  expect(Verdict::Refused, "/zones/0/polygon/0", {1}),
      expect(Verdict::Refused, "/zones/1/line/0", {1, 2, 3});
}

TEST_F(ZonesSchema, AZoneHasEitherAPolygonOrALineAndLinesHaveNoDwell) {
  expect(Verdict::Refused, "/zones/0/line", {{0, 0}, {1, 1}});
  expect(Verdict::Refused, "/zones/1/polygon", {{0, 0}, {1, 1}, {2, 5}});
  expect(Verdict::Refused, "/zones/1/dwell", 5);
  expect(Verdict::Accepted, "/zones/1/comment", 5);
}

TEST_F(ZonesSchema, AGroundHasEitherAScaleOrPoints) {
  expect(Verdict::Refused, "/ground/metres_per_pixel", 0.1);
  const Json four = whole_file()["ground"]["metres"];
  expect(Verdict::Refused, "/ground", {{"metres_per_pixel", 0.1}, {"metres", four}});
  expect(Verdict::Refused, "/ground", {{"metres_per_pixel", 0.1}, {"picture", four}});
  for (const Json& scale : {Json(1e-9), Json(1), Json(1e6)})
    expect(Verdict::Accepted, "/ground", {{"metres_per_pixel", scale}});
  for (const Json& scale : {Json(0), Json(-1), Json(1000001), Json("1"), Json(nullptr)})
    expect(Verdict::Refused, "/ground", {{"metres_per_pixel", scale}});
}

TEST_F(ZonesSchema, HasTheParsersLimitOfZones) {
  EXPECT_EQ(schema->root().at("/properties/zones/maxItems"_json_pointer), zone::kZoneLimit);
}

// docs/zones.md has them; JSON Schema cannot compare values.
TEST_F(ZonesSchema, TheParserRefusesMoreThanASchemaCanSay) {
  const auto only_parser = [this](const char* at, const Json& value) {
    Json file = whole_file();
    file[Json::json_pointer(at)] = value;
    EXPECT_EQ(schema->check(file), "");
    EXPECT_FALSE(zone::parse_zones(file.dump(), "z.json")) << file.dump();
  };
  only_parser("/zones/1/name", "yard");
  only_parser("/zones/1/line/1", {1, 2});
  only_parser("/ground/picture/1", {50, 50});
}

}  // namespace zones_schema_test
}  // namespace weir::records
