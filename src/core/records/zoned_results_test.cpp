// Tests of frames of results that get zones.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/records/zoned_results.hpp"

#include "core/records/records_test_support.hpp"

namespace weir::records {
namespace zoned_results_test {

constexpr char kTracked[] = "x1,y1,x2,y2,score,class,track";

std::string error_of(const std::string& columns, ZonedSettings settings = {}) {
  const auto zoned = ZonedResults::make(parse_roles(columns, ""), settings);
  return zoned ? "" : zoned.error().message();
}

zone::ZoneCounter yard() {
  zone::ZoneCounter out;
  out.set_zones(std::make_shared<const zone::ZoneSet>(zone::ZoneSet{
      {{.name = "yard", .points = {{0, 0}, {100, 0}, {100, 100}, {0, 100}}}}, {}, {}}));
  return out;
}

TEST(ZonedResults, WidensRowsAndAppendsTablesBeforeWhatIsNoResult) {
  auto zoned =
      ZonedResults::make(parse_roles(std::string(kTracked) + ";masks;score,class", "a;a;b"),
                         {.zones_per_object = 1, .source = "z"});
  ASSERT_TRUE(zoned) << zoned.error().message();
  EXPECT_EQ(columns_text(zoned->roles()),
            std::string(kTracked) + ",speed,ground-speed,zone:1,dwell:1;masks;score,class;" +
                kZoneCountColumns + ";" + kZoneEventColumns);
  EXPECT_EQ(sources_text(zoned->roles()), "a;a;b;z;z");
  EXPECT_EQ(zoned->get_source(0), "a");

  // The first row is background, the second not finite.
  const auto frame = TestFrame()
                         .floats("7:4", {0,  0,  0,  0,  0, 0, 0, NAN, 1,  2,   3,  1, 0, 4,  //
                                         40, 40, 60, 60, 1, 3, 5, 140, 40, 160, 60, 1, 4, 6})
                         .bytes("1:1:4", {1, 2, 3, 4})
                         .floats("2:1", {1, 0})
                         .bytes("3", {7, 8, 9});
  std::vector<zone::Sighting> sightings;
  const Status read = zoned->read(frame.tensors, &sightings);
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(sightings.size(), 2u);
  EXPECT_EQ(sightings[0].track, 5u);
  EXPECT_EQ(sightings[0].class_index, 3);
  EXPECT_EQ(sightings[1].box, (Box{140, 40, 160, 60}));
  auto counter = yard();
  counter.update(0, sightings);
  uint64_t unnamed = 0;
  const auto out = zoned->write(frame.tensors, counter, &unnamed);
  ASSERT_EQ(out.size(), 6u);
  EXPECT_EQ(out[0].spec.shape, (Shape{11, 4}));
  EXPECT_EQ(std::vector<float>(out[0].numbers.begin() + 22, out[0].numbers.begin() + 29),
            (std::vector<float>{40, 40, 60, 60, 1, 3, 5}));
  EXPECT_EQ(out[0].numbers[22 + 9], 1) << "the yard";
  EXPECT_EQ(out[0].numbers[33 + 9], 0);
  EXPECT_EQ(out[0].numbers[9], 0) << "background";
  EXPECT_EQ(out[1].input, 1);
  EXPECT_EQ(out[2].input, 2);
  EXPECT_TRUE(out[3].is_table);
  EXPECT_EQ(out[3].spec.shape, (Shape{10, 2}));
  EXPECT_EQ(out[4].spec.shape, (Shape{8, 1}));
  EXPECT_EQ(out[5].input, 3);
  EXPECT_EQ(unnamed, 0u);
}

TEST(ZonedResults, NeedTracks) {
  for (const char* columns : {"", "x1,y1,x2,y2,score,class", "score,class,track", "masks"}) {
    const auto zoned = ZonedResults::make(parse_roles(columns, ""), {});
    EXPECT_FALSE(zoned) << columns;
  }
  const auto text = error_of("x1,y1,x2,y2,score,class");
  EXPECT_SAYS(text, "WEIR-2001: the results have no tracks");
  EXPECT_SAYS(text, "offered: weir-columns=\"x1,y1,x2,y2,score,class\"");
  EXPECT_SAYS(text, "fix: tensor_decoder mode=detection ! tensor_tracker ! tensor_zones");
  EXPECT_SAYS(error_of(""), "offered: a stream without weir-columns");
}

TEST(ZonedResults, CannotHaveZonesTwice) {
  EXPECT_SAYS(error_of(std::string(kTracked) + ";" + kZoneCountColumns),
              "WEIR-2001: the results already have zones");
  EXPECT_SAYS(error_of(std::string(kTracked) + ",speed"), "one tensor_zones for a stream");
}

TEST(ZonedResults, RowsThatBecomeTooLongAreRejected) {
  EXPECT_EQ(error_of("x1,y1,x2,y2,track,mine:60000", {.zones_per_object = 100}), "");
  EXPECT_SAYS(error_of("x1,y1,x2,y2,track,mine:65500", {.zones_per_object = 100}), "WEIR-1001");
}

TEST(ZonedResults, FramesOfAnotherShapeAreRejected) {
  auto zoned = ZonedResults::make(parse_roles(kTracked, ""), {});
  ASSERT_TRUE(zoned);
  std::vector<zone::Sighting> sightings;
  const auto status =
      zoned->read(TestFrame().floats("6:1", std::vector<float>(6)).tensors, &sightings);
  ASSERT_FALSE(status);
  EXPECT_SAYS(status.error().message(), "needed: float32 7:N");
  EXPECT_TRUE(zoned->read({}, &sightings)) << "a frame without tensors has no results";
  EXPECT_TRUE(sightings.empty());
}

}  // namespace zoned_results_test
}  // namespace weir::records
