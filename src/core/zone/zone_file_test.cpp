// Tests of zone files and of the errors about them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/zone/zone_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "says.hpp"

namespace weir::zone {
namespace zone_file_test {

Result<ZoneSet> parsed(const std::string& text) {
  return parse_zones(text, "z.json");
}
// The message for zones that cannot be used.
std::string fault(const std::string& text) {
  const auto zones = parsed(text);
  EXPECT_FALSE(zones) << text;
  return zones ? "" : zones.error().message();
}
std::string with_zone(const std::string& zone) {
  return "{\"version\":1,\"zones\":[" + zone + "]}";
}

TEST(ZoneFile, HasAreasLinesAndAScale) {
  const auto zones = parsed(R"({
    "$schema": "zones-1.schema.json", "comment": "a yard", "version": 1,
    "zones": [
      {"name": "Hof", "polygon": [[0, 0], [10.5, 0], [10, -2]], "reference": "centre", "dwell": 30},
      {"name": "gate", "line": [[1, 2], [3, 4]], "reference": "top", "comment": "north"}],
    "ground": {"metres_per_pixel": 0.5}})");
  ASSERT_TRUE(zones) << zones.error().message();
  ASSERT_EQ(zones->zones.size(), 2u);
  const Zone& yard = zones->zones[0];
  EXPECT_EQ(yard.name, "Hof");
  EXPECT_EQ(yard.kind, Kind::Area);
  ASSERT_EQ(yard.points.size(), 3u);
  EXPECT_EQ(yard.points[1].x, 10.5);
  EXPECT_EQ(yard.points[2].y, -2);
  EXPECT_EQ(yard.reference, Reference::Centre);
  EXPECT_EQ(yard.dwell, 30);
  EXPECT_EQ(zones->zones[1].kind, Kind::Line);
  EXPECT_EQ(zones->zones[1].reference, Reference::Top);
  ASSERT_TRUE(zones->ground);
  EXPECT_EQ(zones->ground->to_metres({4, 2})->x, 2);
}

TEST(ZoneFile, DefaultsAreTheBottomAndNoDwellTime) {
  const auto zones = parsed(with_zone(R"({"name":"a","polygon":[[0,0],[1,0],[1,1]]})"));
  ASSERT_TRUE(zones) << zones.error().message();
  EXPECT_EQ(zones->zones[0].reference, Reference::Bottom);
  EXPECT_EQ(zones->zones[0].dwell, 0);
  EXPECT_FALSE(zones->ground);
  EXPECT_TRUE(parsed(with_zone(""))) << "no zones";
}

TEST(ZoneFile, LinesHaveAMarginUnlessTheFileGivesAnother) {
  const auto margin = [](const std::string& rest) {
    const auto zones = parsed(with_zone(R"({"name":"a",)" + rest + "}"));
    return zones ? zones->zones[0].margin : -1;
  };
  EXPECT_EQ(margin(R"("line":[[0,0],[1,1]])"), 0.1);
  EXPECT_EQ(margin(R"("line":[[0,0],[1,1]],"margin":0)"), 0);
  EXPECT_EQ(margin(R"("line":[[0,0],[1,1]],"margin":10)"), 10);
  EXPECT_EQ(margin(R"("polygon":[[0,0],[1,0],[1,1]])"), 0);
  EXPECT_EQ(margin(R"("polygon":[[0,0],[1,0],[1,1]],"margin":0.5)"), 0.5);
  for (const char* bad : {"-0.1", "10.1", "true", "\"1\"", "null"})
    EXPECT_SAYS(
        fault(with_zone(R"({"name":"a","line":[[0,0],[1,1]],"margin":)" + std::string(bad) + "}")),
        "zones[0].margin is " + std::string(bad) +
            ", needs a part of the longer side of a box, 0 to 10");
}

TEST(ZoneFile, GroundIsAHomographyOfFourPoints) {
  const auto zones = parsed(
      R"({"version":1,"zones":[],"ground":{"picture":[[0,100],[100,100],[75,50],[25,50]],
          "metres":[[0,0],[4,0],[4,10],[0,10]]}})");
  ASSERT_TRUE(zones) << zones.error().message();
  const auto at = zones->ground->to_metres({50, 100});
  EXPECT_NEAR(at->x, 2, 1e-9);
  EXPECT_NEAR(at->y, 0, 1e-9);
}

TEST(ZoneFile, AllFaultsAreReportedAtOnceWithTheirPaths) {
  const auto text = fault(R"({"version": 2, "zones": [
      {"name": "a", "polygon": [[0, 0], [1, 1]]},
      {"name": "a", "line": [[5, 5], [5, 5]]},
      {"polygon": [[0, 0], [1, "x"], [1e7, 1]], "line": [[0, 0], [1, 1]]},
      {"name": "", "polygon": [[0, 0], [1, null], [1e7, 1]], "reference": "middle", "dwell": -1},
      {"name": "l", "line": [[0, 0], [1, 1]], "dwell": 5, "colour": "red"},
      7], "grund": {}})");
  for (const char* words :
       {"z.json", "version is 2, needs 1",
        "zones[0].polygon is [[0,0],[1,1]], needs 3 to 1000 points",
        "zones[1].name is \"a\", needs a unique name: zones[0].name has the same one",
        "zones[1].line is [[5,5],[5,5]], needs two different points", "zones[2].name is missing",
        "needs either \"polygon\" or \"line\"", "zones[3].name is \"\"",
        "zones[3].polygon[1] is [1,null], needs two finite numbers", "zones[3].polygon[2]",
        "zones[3].reference is \"middle\", needs bottom, centre or top",
        "zones[3].dwell is -1, needs seconds above 0", "zones[4].dwell is 5, needs a polygon",
        "zones[4].colour is \"red\"", "zones[5] is 7, needs an object",
        "grund is {}, needs another name: did you mean ground?", "fix: {\"version\": 1"})
    EXPECT_SAYS(text, words);
}

TEST(ZoneFile, ManyFaultsAreCounted) {
  std::string zones;
  for (int i = 0; i < 100; ++i) zones += std::string(i ? "," : "") + "7";
  EXPECT_SAYS(fault(with_zone(zones)), "zones[19] is 7, needs an object");
  EXPECT_SAYS(fault(with_zone(zones)), "; and 80 more");
}

TEST(ZoneFile, RejectsGroundsThatAreNone) {
  const auto ground = [](const std::string& json) {
    return fault(R"({"version":1,"zones":[],"ground":)" + json + "}");
  };
  EXPECT_SAYS(ground("5"), "ground is 5, needs an object with metres_per_pixel");
  EXPECT_SAYS(ground("{}"), "ground.picture is missing, needs 4 points");
  EXPECT_SAYS(ground(R"({"metres_per_pixel":0})"),
              "ground.metres_per_pixel is 0, needs a number above 0 and at most 1000000");
  EXPECT_SAYS(ground(R"({"metres_per_pixel":1,"metres":[]})"), "needs either metres_per_pixel");
  EXPECT_SAYS(ground(R"({"picture":[[0,0],[1,1],[2,2],[5,0]],"metres":[[0,0],[4,0],[4,1],[0,1]]})"),
              "no three of them may lie on a line");
}

TEST(ZoneFile, RejectsWhatIsNotJson) {
  for (const char* text :
       {"", "{", "{\"version\":1,\"zones\":[{\"name\":\"a\",\"polygon\":[[NaN,0]]}]}", "\xff\xfe",
        "{\"version\":1,\"zones\":[[1e999,1]]}"}) {
    const auto message = fault(text);
    EXPECT_SAYS(message, "WEIR-1004: the zones file cannot be used");
    EXPECT_SAYS(message, "it is not JSON: ");
  }
  EXPECT_SAYS(fault("[]"), "the file is [], needs an object");
  EXPECT_SAYS(fault("{}"), "version is missing");
  EXPECT_SAYS(fault("{}"), "zones is missing");
  EXPECT_SAYS(fault(std::string(100000, '[') + std::string(100000, ']')), "nested too deeply");
  EXPECT_SAYS(fault(with_zone(R"({"name":"a\u0000b","polygon":[[0,0],[1,0],[1,1]]})")),
              "zones[0].name");
}

TEST(ZoneFile, HasAtMost10000Zones) {
  std::string zones;
  for (int i = 0; i < 10000; ++i)
    zones += (i ? "," : "") + std::string(R"({"name":")") + std::to_string(i) +
             R"(","polygon":[[0,0],[9,0],[9,9]]})";
  const auto all = parsed(with_zone(zones));
  ASSERT_TRUE(all) << all.error().message();
  EXPECT_EQ(all->zones.size(), 10000u);
  EXPECT_SAYS(fault(with_zone(zones + R"(,{"name":"x","line":[[0,0],[9,0]]})")),
              "needs a list of at most 10000 zones");
}

class ZoneFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        std::filesystem::path(testing::TempDir()) / ("weir-zones-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string error_of(const std::string& path) {
    const auto zones = read_zones(path);
    return zones ? "" : zones.error().message();
  }
  std::filesystem::path folder_;
};

TEST_F(ZoneFiles, AreRead) {
  const auto path = folder_ / "z.json";
  std::ofstream(path) << with_zone(R"({"name":"a","line":[[0,0],[1,0]]})");
  const auto zones = read_zones(path);
  ASSERT_TRUE(zones) << zones.error().message();
  EXPECT_EQ(zones->zones[0].name, "a");
}

TEST_F(ZoneFiles, ThatCannotBeReadSayWhy) {
  const auto missing = error_of(folder_ / "no.json");
  EXPECT_SAYS(missing, "WEIR-4001: the zones file cannot be read");
  EXPECT_SAYS(missing, "no.json: No such file or directory");
  EXPECT_SAYS(missing, "fix: zones=/path/to/zones.json");
  EXPECT_SAYS(error_of(folder_), "it is a folder");
  ASSERT_EQ(mkfifo((folder_ / "fifo").c_str(), 0600), 0);
  EXPECT_SAYS(error_of(folder_ / "fifo"), "it is not a regular file");
}

TEST_F(ZoneFiles, HaveAnotherStateWhenTheyChange) {
  const auto path = folder_ / "z.json";
  const auto none = state_of_file(path);
  std::ofstream(path) << "1";
  const auto first = state_of_file(path);
  EXPECT_NE(none, first);
  EXPECT_EQ(first, state_of_file(path));
  std::ofstream(path) << "12";
  const auto second = state_of_file(path);
  EXPECT_NE(first, second);
  std::ofstream(folder_ / "new.json") << "12";
  std::filesystem::rename(folder_ / "new.json", path);
  EXPECT_NE(second, state_of_file(path));
}

}  // namespace zone_file_test
}  // namespace weir::zone
