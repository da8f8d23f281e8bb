// Tests of columns and tables of zones.
// SPDX-License-Identifier: LGPL-2.1-or-later

#include <gtest/gtest.h>

#include "core/records/zone_columns.hpp"

namespace weir::records {
namespace zone_columns_test {

using Floats = std::vector<float>;

TEST(ZoneColumns, AreFoundByName) {
  const std::string columns = "x1,y1,x2,y2,score,xys:3,mine:5,speed,ground-speed,zone:2,dwell:2";
  EXPECT_EQ(find_column(columns, "x1").first, 0);
  EXPECT_EQ(find_column(columns, "xys").first, 5);
  EXPECT_EQ(find_column(columns, "xys").count, 3u);
  EXPECT_EQ(find_column(columns, "mine").first, 14);
  EXPECT_EQ(find_column(columns, "speed").first, 19);
  EXPECT_EQ(find_column(columns, "zone").first, 21);
  EXPECT_EQ(find_column(columns, "dwell").first, 23);
  EXPECT_EQ(find_column(columns, "dwell").count, 2u);
  EXPECT_EQ(find_column(columns, "spee").first, -1);
  EXPECT_EQ(find_column("", "speed").first, -1);
}

TEST(ZoneColumns, NeedAsManyDwellTimesAsZones) {
  EXPECT_TRUE(zone_columns("speed,zone:2,dwell:2").any());
  EXPECT_FALSE(zone_columns("speed,zone:2,dwell:3").any());
  EXPECT_FALSE(zone_columns("speed").any());
  EXPECT_EQ(with_zone_columns("x1,y1,x2,y2", 3), "x1,y1,x2,y2,speed,ground-speed,zone:3,dwell:3");
}

class ZoneTables : public testing::Test {
 protected:
  // A yard with an object of class 2 and track 5 inside it, and a gate.
  void SetUp() override {
    counter.set_zones(std::make_shared<const zone::ZoneSet>(
        zone::ZoneSet{{{.name = "gate", .kind = zone::Kind::Line, .points = {{0, 0}, {9, 0}}},
                       {.name = "yard", .points = {{0, 0}, {100, 0}, {100, 100}, {0, 100}}},
                       {.name = "all", .points = {{-9, -9}, {100, 0}, {100, 100}, {0, 100}}}},
                      {},
                      {}}));
    counter.update(
        0, std::vector<zone::Sighting>{{.track = 5, .class_index = 2, .box = {40, 40, 60, 60}}});
  }
  zone::ZoneCounter counter;
};

// NaN as -99, so that lists can be compared.
Floats comparable(Floats numbers) {
  for (float& number : numbers)
    if (std::isnan(number)) number = -99;
  return numbers;
}

TEST_F(ZoneTables, HaveARowForEachTotalAndClass) {
  Floats rows;
  append_count_rows(counter, &rows);
  EXPECT_EQ(comparable(rows), (Floats{0, 1, -1, -99, -99, -99, 0,   0,   -99, -99,  //
                                      0, 2, -1, 1,   1,   0,   -99, -99, -99, -99,  //
                                      0, 2, 2,  1,   1,   0,   -99, -99, -99, -99,  //
                                      0, 3, -1, 1,   1,   0,   -99, -99, -99, -99,  //
                                      0, 3, 2,  1,   1,   0,   -99, -99, -99, -99}));
  rows.clear();
  append_event_rows(counter, &rows);
  EXPECT_EQ(comparable(rows), (Floats{0, 2, 1, 2, 5, -99, -99, -99, 0, 3, 1, 2, 5, -99, -99, -99}));
}

TEST_F(ZoneTables, AreARowOfZerosWithoutContent) {
  counter.set_zones(std::make_shared<const zone::ZoneSet>());
  counter.update(1, {});
  Floats rows;
  append_count_rows(counter, &rows);
  EXPECT_EQ(rows, Floats(10));
  rows.clear();
  append_event_rows(counter, &rows);
  EXPECT_EQ(rows, Floats(8));
}

TEST_F(ZoneTables, ColumnsNameAsManyZonesAsFit) {
  Floats two(6, 77), one(4, 77);
  EXPECT_EQ(write_zone_columns(counter, 0, two), 0u);
  EXPECT_EQ(comparable(two), (Floats{-99, -99, 2, 3, 0, 0}));
  EXPECT_EQ(write_zone_columns(counter, 0, one), 1u);
  EXPECT_EQ(comparable(one), (Floats{-99, -99, 2, 0}));
}

}  // namespace zone_columns_test
}  // namespace weir::records
